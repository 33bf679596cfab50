"""Messages to the user: which one is shown, and when it no longer applies."""

from __future__ import annotations

from dataclasses import replace

from cpm_core.numerics.types import frozen


@frozen
class Message:
    """One message.

    Attributes
    ----------
    text : str
        One sentence or several.
    error : bool
        Whether it reports an error.
    category : str
        The kind of attempt that it belongs to, such as ``"export"``; empty for none.
    """

    text: str
    error: bool = False
    category: str = ""


@frozen
class Messages:
    """All messages that still apply.

    The newest is shown. News gives way to errors; an error stays until it is dismissed,
    or until the attempt that it belongs to is repeated.

    Attributes
    ----------
    errors : tuple of Message
        Errors, the newest last, one for each category.
    news : Message or None
        The last good news.
    """

    errors: tuple[Message, ...] = ()
    news: Message | None = None

    @property
    def shown(self) -> Message | None:
        """The message that is shown."""
        return self.news or (self.errors[-1] if self.errors else None)

    def with_message(self, message: Message) -> Messages:
        """Add a message.

        It replaces all news, and the errors of its category; news of no category replaces no error.
        """
        replacing = message.error or message.category
        others = tuple(error for error in self.errors if not replacing or error.category != message.category)
        return Messages((*others, message)) if message.error else Messages(others, message)

    def without_categories(self, *categories: str) -> Messages:
        """Drop the messages of some categories, which are attempted again."""
        errors = tuple(error for error in self.errors if error.category not in categories)
        return Messages(errors, None if self.news is not None and self.news.category in categories else self.news)

    def only_categories(self, *categories: str) -> Messages:
        """Drop the messages of all other categories."""
        kept = self.news if self.news is not None and self.news.category in categories else None
        return Messages(tuple(error for error in self.errors if error.category in categories), kept)

    def without_news(self) -> Messages:
        """Drop the news."""
        return replace(self, news=None)

    def without_shown(self) -> Messages:
        """Drop the message that is shown."""
        return self.without_news() if self.news is not None else Messages(self.errors[:-1])
