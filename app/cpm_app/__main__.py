"""Entry point of ``cpm`` and ``python -m cpm_app``: the window, or the command line for a subcommand."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Sequence

EXIT_CANNOT_OPEN = 2
"""Exit status when no window can be opened, or the arguments are invalid."""

EXIT_ON_INTERRUPT = 130
"""Exit status after Ctrl+C, as shells report it."""

_COMMAND_NAMES = frozenset({"run", "info", "batch", "skeleton", "compare", "bench", "export", "model", "completion"})
"""Names of the subcommands, which are imported only when one is called."""

_QT_PACKAGES = frozenset({"PySide6", "shiboken6", "pyqtgraph"})
"""Packages that only the window needs."""

_MISSING_QT_ERROR = (
    "The window needs Qt, which is not installed: run pip install '.[gui]' in the folder of the README, or work "
    "without a window by “cpm run IMAGE …”."
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run CPM.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments after the program's name: nothing, an image or a folder of images for the window, else a subcommand or
        options.

    Returns
    -------
    int
        Exit status; 2 when the window cannot be opened or the arguments are invalid.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        first = arguments[0] if arguments else ""
        if first in _COMMAND_NAMES or first.startswith("-") or "_ARGCOMPLETE" in os.environ:
            from cpm_core import cli

            return cli.main(arguments)
        if arguments and not os.path.lexists(first):  # a pattern, or a mistyped word, for which no window opens
            from cpm_core.cli.inputs import expand_paths

            try:
                arguments = expand_paths(arguments)
            except ValueError as error:
                return _print_error(str(error))
            if not os.path.lexists(arguments[0]):
                from cpm_core.parameters.formatting import suggest_name

                near = suggest_name(first, _COMMAND_NAMES) or "see cpm --help."
                return _print_error(f"“{first}” is no command and no file: {near}")
        option = next((each for each in arguments if each.startswith("-")), "")
        if option:
            return _print_error(f"{option} is for a command, which comes first: cpm run {first} {option}.")
        if len(arguments) > 1:
            return _print_error(f"The window opens one image but {len(arguments)} were given; see cpm --help.")
        return _open_window(arguments[0] if arguments else None)
    except KeyboardInterrupt:
        print("cpm: interrupted.", file=sys.stderr)
        return EXIT_ON_INTERRUPT


def _open_window(path: str | None) -> int:
    gc.disable()  # imports leave no garbage to collect
    # Qt is imported only here, so that the command line works without it.
    try:
        from PySide6.QtCore import QLocale

        from cpm_app.model.text import language
        from cpm_app.session.storage.preferences import Preferences

        # Before any module whose sentences are translated while it is imported.
        of_the_system = QLocale.system().uiLanguages()
        language.use_language(Preferences().read_key(language.LANGUAGE_KEY, language.SYSTEM_LANGUAGE), of_the_system)
        reason = explain_no_window()
        if reason:
            return _print_error(reason)
        from cpm_app.views.application import run_application
    except ImportError as error:
        if error.name in _QT_PACKAGES and isinstance(error, ModuleNotFoundError):
            return _print_error(_MISSING_QT_ERROR)
        return _print_error(
            f"The window cannot be opened because a library cannot be loaded ({error}); see the README."
        )
    gc.enable()
    return run_application(path)


def explain_no_window() -> str:
    """Explain in one sentence why no window can be opened here; empty where one can."""
    chosen = os.environ.get("QT_QPA_PLATFORM", "")
    if not sys.platform.startswith("linux") or chosen.partition(":")[0] not in ("", "xcb"):
        return ""
    if not chosen and os.environ.get("WAYLAND_DISPLAY"):
        return ""
    if not os.environ.get("DISPLAY"):
        return "There is no display to open a window on; use “cpm run IMAGE …” to work without one."
    # The plugin of Qt is loaded here, because only the loader reports which library is missing.
    import ctypes

    from PySide6.QtCore import QLibraryInfo

    plugins = QLibraryInfo.path(QLibraryInfo.LibraryPath.PluginsPath)
    try:
        ctypes.CDLL(f"{plugins}/platforms/libqxcb.so")
    except OSError as error:
        library = str(error).partition(":")[0]
        return f"Qt cannot open a window because {library} is missing; the README names what Qt needs."
    return ""


def _print_error(sentence: str) -> int:
    print(f"cpm: {sentence}", file=sys.stderr)
    return EXIT_CANNOT_OPEN


if __name__ == "__main__":
    sys.exit(main())
