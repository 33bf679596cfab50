"""``cpm model``: lists the larger models that answer prompts, and fetches one."""

from __future__ import annotations

import argparse

from cpm_core.cli.output import StatusLine, print_json
from cpm_core.numerics.types import JsonDict
from cpm_core.objects.prior.larger_models import MODELS, fetch_model, is_fetched

_BAR_WIDTH = 40
"""Width of the bar of progress [characters]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("model", nargs="?", metavar="NAME", choices=tuple(MODELS), help="The model to fetch.")


def show_models(arguments: argparse.Namespace) -> None:
    """Fetch the named model, if any, and list it, or all."""
    if arguments.model is not None and not is_fetched(arguments.model):
        with StatusLine() as line:
            summary = MODELS[arguments.model].summary

            def show_share(share: float) -> None:
                line.show_text(f"{summary} [{'=' * round(share * _BAR_WIDTH):{_BAR_WIDTH}}]")

            fetch_model(arguments.model, show_share)
    facts: list[JsonDict] = []
    for name in MODELS if arguments.model is None else (arguments.model,):
        one = MODELS[name]
        facts.append(
            {"name": name, "title": one.title, "megabytes": one.megabytes, "license": one.license}
            | {"fetched": is_fetched(name)}
        )
        if not arguments.json:
            print(f"{name:18}{one.summary}{', on this computer' if facts[-1]['fetched'] else ''}")
    if arguments.json:
        print_json(arguments.name, {"models": facts})
