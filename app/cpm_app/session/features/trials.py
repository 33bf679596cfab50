"""Trials: runs with other parameters, or of other methods, several at a time."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

from cpm_app.model.display.comparison import Trial
from cpm_app.model.document.document import Document
from cpm_app.model.document.running import run_document
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import Reconstruction, explain_failure
from cpm_app.session.scene import Scene
from cpm_app.session.tasks.tasks import BackgroundTask, Cancelled
from cpm_core import CONTOUR_METHODS, Engine, Image, Result, Start, iterate_method, report_run
from cpm_core.methods import build_method_result
from cpm_core.numerics import count_cores
from cpm_core.shapes import SeedCache, drawn_outlines


def start_for_methods(document: Document) -> Start:
    """Return the start for all methods; raise ValueError if no outline is drawn."""
    return Start(drawn_outlines(document.shapes), document.comparison.around)


def scene_from_result(found: Result) -> Scene:
    """Make the scene of a result that is not of the session's run."""
    return Scene(reconstruction=Reconstruction(0, found))


def run_trials(
    image: Image,
    document: Document,
    trials: Mapping[int, Trial],
    report: Callable[[int, dict[str, object]], object],
    task: BackgroundTask,
) -> None:
    """Run trials, one on each core but the one that the window needs.

    Parameters
    ----------
    image, document : Image and Document
        The image, and the document whose starts and regions are used.
    trials : mapping of int to Trial
        The trials, each with its key.
    report : callable
        Called on other threads with the key of a trial and the parts of its row that have changed.
    task : BackgroundTask
        Its progress; cancelling it ends all of them.
    """
    seed_cache, engines, lock = SeedCache(image), dict[int, Engine](), threading.Lock()

    def run_parameters(trial: Trial) -> Result:
        own, scales = replace(document, parameters=trial.settings), trial.settings.scales
        with lock:  # fields and seeds shared by trials are made once
            seeds = own.find_image_seeds(seed_cache)
            if scales not in engines:
                engines[scales] = Engine(image, trial.settings, document.regions)
        return run_document(engines[scales], own, seeds, lambda _: task.check_cancelled())

    def run_other_method(trial: Trial) -> Result:
        method, start, channel = CONTOUR_METHODS[trial.method], start_for_methods(document), document.parameters.channel
        plain = method.of_particles or image.colors is None or channel == "luminance"
        taken = image if plain else Image(image.gray_levels(channel), source=image.source)
        for moment in iterate_method(method, taken, start, trial.settings):
            task.check_cancelled()
            last = moment
        return build_method_result(report_run(last), last.state.contours, taken, start, trial.settings)

    def run_trial(key: int) -> None:
        trial = trials[key]
        try:
            task.check_cancelled()
            report(key, {"state": tr("running…")})
            at = time.perf_counter()
            found = (run_other_method if trial.method else run_parameters)(trial)
            seconds = time.perf_counter() - at
            report(key, {"found": found, "scene": scene_from_result(found), "seconds": seconds, "state": ""})
        except Cancelled:
            return
        except Exception as error:  # shown in its row, and the others continue
            report(key, {"state": explain_failure(error, tr("running {name}", name=trial.title))})

    with ThreadPoolExecutor(max(1, count_cores() - 1), thread_name_prefix="cpm-compare") as pool:
        for done, _ in enumerate(pool.map(run_trial, trials), start=1):
            task.fraction = done / len(trials)
