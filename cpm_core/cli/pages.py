"""``cpm run STACK --pages``: finds the contours on each page of a stack, and follows objects from page to page."""

from __future__ import annotations

import time
from contextlib import suppress

from cpm_core.cli.arguments import parse_number_ranges
from cpm_core.cli.inputs import list_image_notes
from cpm_core.cli.output import (
    EXIT_IN_PART,
    OutputFiles,
    StatusLine,
    collect_run_facts,
    describe_contour_count,
    ensure_compiled,
    print_notes,
    print_report,
)
from cpm_core.cli.run_request import RunRequest
from cpm_core.formats import load_pages
from cpm_core.formats.common.provenance import describe_shapes
from cpm_core.formats.stack_files import export_stack
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array, JsonDict
from cpm_core.objects.segmented import collect_points
from cpm_core.pages.follow import follow_pages, limit_scales
from cpm_core.pages.objects import follow_objects
from cpm_core.pages.page import Page, StackResult
from cpm_core.parameters.formatting import format_count
from cpm_core.results.result import Result
from cpm_core.segmentation.evolve import segment
from cpm_core.shapes.document_shapes import collect_charges, collect_regions, compute_seeds


def run_pages(request: RunRequest) -> int:
    """Run the pages, and write what is found on all of them; after Ctrl+C, what has been done is written."""
    assert request.pages is not None
    pages, parameters = load_pages(request.path, **request.part), request.parameters
    numbers = parse_number_ranges("--pages", request.pages, len(pages), "page", pages.name)
    shapes = (*request.session.shapes, *request.drawn)
    with suppress(ValueError):  # which is reported when the page is run
        print_notes(pages.name, list_image_notes(pages[numbers[0] - 1], parameters))
    ensure_compiled()
    began = time.perf_counter()
    found: list[Page] = []
    limits: JsonDict = {
        "max_steps": request.max_steps,
        "regions": collect_regions(shapes, request.session.objects.barriers),
        "charges": collect_charges(shapes),
    }

    def compute_page_seeds(image: Image) -> Array:
        return compute_seeds(image, request.collect_shapes(image), parameters.smoothing, parameters.channel)

    def segment_page(image: Image) -> Result:
        return segment(image, compute_page_seeds(image), limit_scales(parameters, image.shape), **limits)

    if request.clicked:
        positive, negative = (collect_points(request.clicked[0], inside=inside) for inside in (True, False))
        runs = follow_objects(pages, segment_page, positive, negative, numbers, request.model)
    else:
        fresh = not request.follows_pages
        how: JsonDict = {"numbers": numbers, "fresh": fresh, "objects": request.all_objects}
        runs = follow_pages(pages, compute_page_seeds, parameters, **how, **limits)
    interrupted, files = False, OutputFiles()
    try:
        with StatusLine() as line:
            for page in runs:
                found.append(page)
                line.show_count(len(found), len(numbers))
                if page.error:
                    line.print_above(f"page {page.number}: {page.error}")
    except KeyboardInterrupt:
        interrupted = True
    drawn = (*describe_shapes(shapes), *request.describe_start_files())
    about = pages.axis, pages.has_single_axis, drawn, pages.interval
    whole = StackResult(pages.name, len(pages), tuple(found), *about)
    if interrupted and not (whole.results and request.exports):
        raise KeyboardInterrupt
    if not whole.results:
        raise ValueError(f"No page of {pages.name} could be used. Page {found[0].number}: {found[0].error}")
    with files.record_writing(*request.exports):
        export_stack(whole, *request.exports, refused=files.refuse_file)
    if interrupted:
        done = f"{len(found)} of {format_count(len(numbers), 'page')} were done, and the files hold them"
        raise KeyboardInterrupt(f"{done}; --pages runs the others")
    status = _print_page_report(request.as_json, whole, files, time.perf_counter() - began)
    return status or (EXIT_IN_PART if len(whole.results) < len(found) else 0)


def _print_page_report(as_json: bool, found: StackResult, files: OutputFiles, seconds: float) -> int:
    plain: list[JsonDict] = []
    lines: list[str] = []
    said: list[str] = []
    for page in found.pages:
        facts: JsonDict = {}
        if page.result is not None:
            facts = collect_run_facts(page.result)
            objects = len({one.group for one in page.contours if one.group})
            count = format_count(objects, "object") if objects else describe_contour_count(page.result)
            lines.append(f"page {page.number}: {count}")
        events = [event.sentence for event in page.events]
        said += events
        plain.append({"page": page.number, **facts, "events": events, "trouble": page.error})
    tracks, failed = len(found.tracks), len(found.pages) - len(found.results)
    counts = f"{format_count(len(found.pages), 'page')}, {format_count(tracks, 'track')} in {seconds:.2f} s"
    last = f"{found.source}: {counts}" + (f", {failed} failed" if failed else "")
    whole = {"tracks": tracks, "done": len(found.results), "failed": failed, "seconds": round(seconds, 3)}
    return print_report("run", as_json, {"pages": plain, **whole}, [*lines, *said, last], files)
