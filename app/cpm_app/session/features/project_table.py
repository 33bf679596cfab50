"""The table of all objects of all images of a project, made from their sessions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from cpm_app.model.document.document import ImageReference
from cpm_app.model.document.saving import from_session_file
from cpm_app.model.export import ExportOrder, has_objects_to_export, prepare_export
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import FilesExported
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_core import Result, load_image, load_volume
from cpm_core.formats import encode_tables_of_images, load_session, project_session, write_together


def write_table(images: Sequence[Path], empty: int, path: Path, task: BackgroundTask) -> FilesExported:
    """Write one table of the objects of images as their sessions have them; for use on a thread.

    Open objects, which enclose nothing, and images without objects have no rows; images that cannot be read are
    counted; so are the `empty` ones that are done without an object. ValueError if there is no object.
    """
    counts: list[int] = []
    failed = 0

    def measure_images() -> Iterator[Result]:
        nonlocal failed
        for done, image in enumerate(images):
            task.advance(done / len(images))
            try:
                result = _objects_of(image, task)
            except ValueError:
                failed += 1
                continue
            if result is not None:
                numbers = {contour.group for contour in result.contours if contour.closed}
                counts.append(len(numbers) if result.surface is None else len(result.surface.labels))
                yield result

    content = encode_tables_of_images(measure_images())
    if not any(counts):
        raise ValueError(tr("There is no object in any image of this folder yet."))
    write_together([(path, content)])
    parts = [tr("{objects} objects in {images} images", objects=sum(counts), images=sum(map(bool, counts)))]
    if empty:
        parts.append(tr("done without an object: {count}", count=empty))
    if failed:
        parts.append(tr("{failed} could not be used.", failed=failed))
    return FilesExported(path, "; ".join(parts))


def _objects_of(path: Path, task: BackgroundTask) -> Result | None:
    """Return the objects of an image, or of a volume, as exports measure them; None if there are none."""
    file = load_session(project_session(path))
    if file.image is None or not file.objects.items:
        return None
    load = load_volume if len(file.image.shape) == 3 else load_image
    image = load(path, check_cancelled=task.check_cancelled, **file.image.reading.arguments)
    document = from_session_file(file, ImageReference.from_image(path, image, file.image.reading), file.parameters)
    if not has_objects_to_export(document):
        return None
    result = prepare_export(None, document, ExportOrder(), "objects", image)
    return result if isinstance(result, Result) else None
