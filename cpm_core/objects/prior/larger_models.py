"""Larger models that answer prompts in place of the network: those that osam fetches, or ONNX files of a user.

Each has an encoder, which sees an image once, and a decoder, which answers points and boxes. They run on this computer;
only `fetch_model` reaches for another one.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.numerics.packages import MissingPackageError, has_package, require_package
from cpm_core.numerics.types import Array, Extent, Index, JsonDict, Numbers, Single, frozen
from cpm_core.parameters.formatting import quote_value


@frozen
class LargerModel:
    """A model that can be fetched.

    Attributes
    ----------
    title : str
        Its name for people.
    megabytes : int
        Size of its files [MB].
    license : str
        License of its weights.
    """

    title: str
    megabytes: int
    license: str = "Apache License 2.0"

    @property
    def summary(self) -> str:
        """Its title, size and license on one line."""
        return f"{self.title}: {self.megabytes} MB, {self.license}"


MODELS = {
    "efficientsam:10m": LargerModel("EfficientSAM 10M", 40),
    "efficientsam": LargerModel("EfficientSAM 30M", 100),
    "sam:100m": LargerModel("SAM 100M", 100),
    "sam:300m": LargerModel("SAM 300M", 310),
    "sam": LargerModel("SAM 600M", 630),
    "sam2:tiny": LargerModel("SAM 2 Tiny", 150),
    "sam2:small": LargerModel("SAM 2 Small", 170),
    "sam2": LargerModel("SAM 2 Base Plus", 300),
    "sam2:large": LargerModel("SAM 2 Large", 870),
}
"""Models that can be fetched, by the names that osam gives them. Its SAM 3 answers no points."""

_KINDS = {"batched_images": "efficientsam", "x": "sam", "input": "sam2"}
"""Name of a model of the same kind, by the input of the encoder."""

_MAX_SEEN_IMAGES = 4
"""Number of images whose embeddings are kept."""


def fetch_model(name: str, progress: Callable[[float], object] = lambda _: None) -> None:
    """Fetch the weights of a larger model, once; they stay in the folder of osam.

    Parameters
    ----------
    name : str
        One of `MODELS`.
    progress : callable
        Is called with the share that has arrived, 0 to 1; may raise to stop.

    Raises
    ------
    ValueError
        When there is no such model, osam is not installed, or the weights do not arrive.

    Examples
    --------
    >>> cpm.MODELS["sam2:tiny"]
    LargerModel(title='SAM 2 Tiny', megabytes=150, license='Apache License 2.0')
    """
    if name not in MODELS:
        raise ValueError(f"The model {quote_value(name)} cannot be fetched: choose one of {', '.join(MODELS)}.")
    arrived: dict[str, int] = {}
    stopped, reasons = threading.Event(), list[Exception]()

    def report(file: str, count: int, _: int | None) -> None:
        arrived[file] = count
        try:
            progress(min(sum(arrived.values()) / (1e6 * MODELS[name].megabytes), 1.0))
        except Exception as reason:  # osam would try again
            reasons.append(reason)
            stopped.set()
            raise

    try:
        _find_kind(name).pull(progress=report, cancel=stopped)
    except RuntimeError as error:
        if reasons:
            raise reasons[0] from None
        raise ValueError(f"{MODELS[name].title} could not be fetched: {error}") from None


def is_fetched(name: str) -> bool:
    """Return whether the weights of one of `MODELS` are on this computer, and osam, which runs them."""
    return has_package("osam") and _find_kind(name).get_size() is not None


def check_model(name: str, ndim: int) -> None:
    """Raise ValueError unless a name is empty, or of a model that can answer in images (2) or volumes (3).

    In images it must be on this computer; in volumes it is the address of a server, which is not asked yet.
    """
    is_server = name.startswith(("http://", "https://"))
    if name and is_server != (ndim == 3):
        here, there = ("volumes", "images") if is_server else ("images", "volumes")
        raise ValueError(f"{model_title(name)} answers in {here}, not in {there}: leave the model out.")
    if is_server and not has_package("nnInteractive"):
        raise MissingPackageError("A server", "nninteractive-client")
    if name and not is_server:
        _find_files(name)


def model_title(name: str) -> str:
    """Return the name of a model for files: of a folder its own name, of a server the host; empty for the network."""
    return name if name in MODELS else Path(name).name


def encode_image(name: str, pixels: Numbers) -> Any:
    """Encode an image, shape (H, W, 3), uint8, by a model; the embeddings of the last images are kept."""
    return _encode_bytes(name, pixels.tobytes(), pixels.shape)


def decode_prompt(name: str, embedding: Any, places: Array, labels: Index) -> tuple[Single, Single]:
    """Decode a prompt on an encoded image by a model.

    Parameters
    ----------
    name : str
        The model.
    embedding : osam.types.ImageEmbedding
        What `encode_image` has returned.
    places : ndarray, shape (N, 2)
        Points (row, col) [px].
    labels : ndarray of int64, shape (N,)
        1 for a positive point, 0 for a negative one, 2 and 3 for the first and the last corner of a box.

    Returns
    -------
    logits : ndarray of float32, shape (K, H, W)
        Several answers.
    predicted_ious : ndarray of float32, shape (K,)
        Overlap of each with the object, as predicted.
    """
    sessions = _open_model(name)._inference_sessions
    points, marks = places[:, ::-1].astype(np.float32), labels.astype(np.float32)
    seen: JsonDict = {"image_embeddings": embedding.embedding[None]}
    shape = embedding.original_height, embedding.original_width
    kind, side = _KINDS[sessions["encoder"].get_inputs()[0].name], sessions["encoder"].get_inputs()[0].shape[-1]
    if kind == "efficientsam":
        seen |= {"batched_point_coords": points[None, None], "batched_point_labels": marks[None, None]}
    else:
        if kind == "sam":  # the image keeps its proportions, and a point that says nothing ends the prompt
            points = np.concatenate([points * np.float32(side / max(shape)), np.zeros((1, 2), np.float32)])
            marks = np.append(marks, np.float32(-1.0))
        else:
            points = points * np.array([side / shape[1], side / shape[0]], np.float32)
            finer, finest = embedding.extra_features[1], embedding.extra_features[0]
            seen |= {"high_res_features1": finest[None], "high_res_features2": finer[None]}
        seen |= {"point_coords": points[None], "point_labels": marks[None]}
        seen |= {"mask_input": np.zeros((1, 1, 256, 256), np.float32), "has_mask_input": np.zeros(1, np.float32)}
    seen["orig_im_size"] = np.array(shape, np.float32 if kind == "sam" else np.int64)
    logits, scores, *_ = sessions["decoder"].run(None, seen)
    return logits.reshape(-1, *shape), scores.ravel()


def _import_osam() -> Any:
    require_package("osam", "A larger model")
    import loguru
    import osam

    loguru.logger.disable("osam")  # it would write to standard error
    return osam


def _find_kind(name: str) -> Any:
    """Find the class of osam for one of `MODELS`."""
    return _import_osam().apis.get_model_type_by_name(name)


def _find_files(name: str) -> dict[str, Path]:
    """Find the files of an encoder and a decoder; ValueError when they are not on this computer."""
    if name in MODELS:
        kind = _find_kind(name)
        if not is_fetched(name):
            raise ValueError(f"{MODELS[name].title} is not on this computer: fetch it once by cpm model {name}.")
        return {part: Path(blob.path) for part, blob in kind._blobs.items()}
    files = {part: sorted(Path(name).glob(f"*{part}*.onnx")) for part in ("encoder", "decoder")}
    if any(len(found) != 1 for found in files.values()):
        raise ValueError(
            f"The model {quote_value(name)} is not known: choose one of {', '.join(MODELS)}, or a folder with two "
            "files, *encoder*.onnx and *decoder*.onnx."
        )
    return {part: found[0] for part, found in files.items()}


@lru_cache(maxsize=1)
def _open_model(name: str) -> Any:
    """Open a model of osam with the files that are here; its constructor would fetch others."""
    files, sessions = _find_files(name), {}
    _import_osam()  # says how to install what is missing
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    here = onnxruntime.get_available_providers()
    usable = [one for one in ("CUDAExecutionProvider", "CPUExecutionProvider") if one in here]
    try:
        for part, path in files.items():
            sessions[part] = onnxruntime.InferenceSession(str(path), options, providers=usable)
        kind = _find_kind(_KINDS[sessions["encoder"].get_inputs()[0].name])
    except Exception as error:  # of many types, which onnxruntime does not name
        raise ValueError(f"{model_title(name)} is no model of a known kind: {error}") from None
    model = kind.__new__(kind)
    model._inference_sessions = sessions
    return model


@lru_cache(maxsize=_MAX_SEEN_IMAGES)
def _encode_bytes(name: str, pixels: bytes, shape: Extent) -> Any:
    return _open_model(name).encode_image(np.frombuffer(pixels, np.uint8).reshape(shape))
