"""Projects: the images of a folder with the state of each, in a JSON file next to their sessions.

The images stay as they are: the project of a folder is its subfolder `PROJECT_FOLDER`, with one session for each image
that has been worked on, and one file `PROJECT_FILE` with the states and the settings of new images.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import Literal

from cpm_core.formats.common.atomic import write_together
from cpm_core.formats.common.content import read_content
from cpm_core.formats.common.json_values import encode_json, expect_mapping, from_json, to_json
from cpm_core.formats.common.provenance import PROGRAM_NAME
from cpm_core.formats.sessions.session_file import SESSION_SUFFIX, SessionFile, decode_session, encode_session
from cpm_core.numerics.types import JsonDict, frozen
from cpm_core.parameters.formatting import quote_value

PROJECT_FOLDER = "cpm"
"""Name of the subfolder of a project, inside the folder of the images."""

PROJECT_FILE = "project.json"
"""Name of the file with the states, in that subfolder."""

PROJECT_MARK = "cpm-project"
"""Key that distinguishes a project from other JSON."""

PROJECT_VERSION = 1
"""Version of the format: value of this entry."""

_MAX_PROJECT_SIZE = 16 * 2**20
"""Largest size of a project file [bytes]."""

ImageState = Literal["untouched", "begun", "done", "doubtful"]
"""How far the work on an image is: nothing yet, something, and what the user says of it."""


@frozen
class ProjectImage:
    """What a project says of an image: its state, and the number of its objects."""

    state: ImageState = "untouched"
    objects: int = 0


@frozen
class Project:
    """Content of a project file.

    Attributes
    ----------
    images : mapping of str to ProjectImage
        The images that have been worked on, by the names of their files.
    settings : SessionFile or None
        Session that new images begin with; None while no image has been worked on.
    proposes : bool
        Whether new images are run as soon as they are opened.
    """

    images: Mapping[str, ProjectImage] = field(default_factory=dict)
    settings: SessionFile | None = None
    proposes: bool = False

    def with_image(self, name: str, image: ProjectImage) -> Project:
        """Return the project with what it says of an image replaced."""
        return replace(self, images={**self.images, name: image})


def project_session(image: Path) -> Path:
    """Return the path of the session of an image in its project; images ``a.png`` and ``a.tif`` have different ones."""
    return image.parent / PROJECT_FOLDER / f"{image.name}{SESSION_SUFFIX}"


def load_project(folder: Path) -> Project:
    """Read the project of a folder of images.

    Parameters
    ----------
    folder : Path
        Folder of the images.

    Returns
    -------
    Project
        Its content; an empty one if there is no file.

    Raises
    ------
    ValueError
        When the file cannot be read or is damaged; one sentence that says what is wrong.
    """
    path = folder / PROJECT_FOLDER / PROJECT_FILE
    if not path.exists():
        return Project()
    where = f"{PROJECT_FOLDER}/{PROJECT_FILE}"
    try:
        plain = json.loads(read_content(path, _MAX_PROJECT_SIZE).decode())
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise ValueError(f"{where} is damaged and is left as it is: get a sound copy of it, or remove it.") from error
    version = plain.get(PROJECT_MARK) if isinstance(plain, dict) else None
    if version != PROJECT_VERSION or isinstance(version, bool):
        raise ValueError(
            f"{where} is not a project of version {PROJECT_VERSION} and is left as it is: get a newer CPM for it, or "
            "remove it."
        )
    try:
        named = expect_mapping(plain.get("images", {}), "images")
        settings = plain.get("settings")
        return Project(
            {name: from_json(ProjectImage, entry, quote_value(name)) for name, entry in named.items()},
            None if settings is None else decode_session(json.dumps(settings).encode(), "settings"),
            plain.get("proposes") is True,
        )
    except ValueError as error:
        raise ValueError(f"{where} is damaged and is left as it is: {error}") from error


def update_project(folder: Path, change: Callable[[Project], Project]) -> None:
    """Change the project of a folder of images on the disk, atomically.

    The file is read again before, so that what another window has written in the meantime about other images stays.

    Parameters
    ----------
    folder : Path
        Folder of the images; the folder of the project is created if it is missing.
    change : callable
        Returns the changed content.

    Raises
    ------
    ValueError
        When the file cannot be written, or there is one that cannot be read, which stays as it is.
    """
    project = change(load_project(folder))
    plain: JsonDict = {PROJECT_MARK: PROJECT_VERSION, "program": PROGRAM_NAME}
    plain["images"] = {name: to_json(image) for name, image in project.images.items()}
    if project.settings is not None:
        plain["settings"] = json.loads(encode_session(project.settings, Path()))
    plain["proposes"] = project.proposes
    make_project_folder(folder)
    write_together([(folder / PROJECT_FOLDER / PROJECT_FILE, encode_json(plain))])


def make_project_folder(folder: Path) -> None:
    """Create the folder of a project, if it is missing; ValueError if that is not possible."""
    try:
        (folder / PROJECT_FOLDER).mkdir(exist_ok=True)
    except OSError as error:
        raise ValueError(
            f"{folder.name}/{PROJECT_FOLDER} cannot be created, so work on these images is not saved: {error.strerror}."
        ) from error
