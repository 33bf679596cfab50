"""Entry point of ``cpm`` and ``python -m app``: the window, or the command line for a subcommand."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

CANNOT_OPEN = 2
INTERRUPTED = 130

_COMMANDS = frozenset({"run", "info", "batch", "skeleton", "compare", "bench", "export", "completion"})

_QT = frozenset({"PySide6", "shiboken6", "pyqtgraph"})

_NO_QT = (
    'The window needs Qt, which is not installed: run pip install "cpm-particles[gui]", or work without a window by '
    "“cpm run IMAGE …”."
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run CPM.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments after the program's name: nothing or an image for the window, else a subcommand or options.

    Returns
    -------
    int
        Exit status; 2 when the window cannot be opened or the arguments are invalid.
    """
    _hold_closed_streams()
    try:
        _end_at_once_if_interrupted()
        return _run(list(sys.argv[1:] if argv is None else argv))
    except KeyboardInterrupt:
        print("cpm: interrupted.", file=sys.stderr)  # again, or as the window opens
        return INTERRUPTED
    finally:
        _interrupt_as_usual()


def _hold_closed_streams() -> None:
    """Let no file that is opened later take the place of a closed standard stream, where libraries write as well."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free


def _end_at_once_if_interrupted() -> None:
    """Let Ctrl+C end the program while libraries are loaded: some would make another error of it."""
    import signal  # loads others: whoever interrupts that is answered already

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        try:
            signal.signal(signal.SIGINT, _end_at_once)
        except ValueError:  # only the main thread is interrupted
            return


def _end_at_once(*_: object) -> None:
    os.write(2, b"cpm: interrupted; nothing was written.\n")
    os._exit(INTERRUPTED)


def _interrupt_as_usual() -> None:
    import signal

    if signal.getsignal(signal.SIGINT) is _end_at_once:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _run(arguments: Sequence[str]) -> int:
    asked_by_shell = "_ARGCOMPLETE" in os.environ
    if asked_by_shell or (arguments and (arguments[0] in _COMMANDS or arguments[0].startswith("-"))):
        from cpm_core import cli

        _interrupt_as_usual()
        return cli.main(arguments)
    paths = list(arguments)
    if arguments and not os.path.lexists(arguments[0]):  # a word that was mistyped opens no window
        from cpm_core.cli.help import no_command_or_file
        from cpm_core.cli.inputs import expanded

        try:
            paths = expanded(arguments)
        except ValueError as error:
            return _refuse(str(error))
        if paths == list(arguments):
            return _refuse(no_command_or_file(arguments[0], _COMMANDS))
    if len(paths) > 1:
        return _refuse(f"The window opens one image but {len(paths)} were given; see cpm --help.")
    return _open_window(paths[0] if paths else None)


def _open_window(path: str | None) -> int:
    # Qt is imported only here, so that the command line works without it.
    try:
        from PySide6.QtCore import QLocale

        from app.model.text import language
        from app.session.storage.preferences import Preferences

        # Before any module whose sentences are translated while it is imported.
        of_the_system = QLocale.system().uiLanguages()
        language.use_language(Preferences().get(language.KEY, language.OF_THE_DESKTOP), of_the_system)
        from app.views.window.display import why_no_window

        reason = why_no_window()
        if reason:
            return _refuse(reason)
        from app.views.application import run
    except ImportError as error:
        if error.name in _QT and isinstance(error, ModuleNotFoundError):
            return _refuse(_NO_QT)
        return _refuse(f"The window cannot be opened because a library cannot be loaded ({error}); see the README.")
    _interrupt_as_usual()
    return run(path)


def _refuse(sentence: str) -> int:
    print(f"cpm: {sentence}", file=sys.stderr)
    return CANNOT_OPEN


if __name__ == "__main__":
    sys.exit(main())
