"""Small ONNX files with the inputs and outputs of EfficientSAM, SAM and SAM 2.

Their answers to a prompt are the pixels whose gray level is that of the middle of its positive points and corners:
about, roughly, and very roughly.
"""

from pathlib import Path

import pytest

HEAD = '<ir_version: 8, opset_import: ["" : 17]>'

SEEN_SIDE = 256

ENCODERS = {
    "efficientsam": f"""{HEAD} encoder (float[1, 3, H, W] batched_images) => (float[1, 1, H, W] image_embeddings) {{
        image_embeddings = ReduceMean <axes = [1]> (batched_images)
    }}""",
    "sam": f"""{HEAD} encoder (float[1, 3, {SEEN_SIDE}, {SEEN_SIDE}] x) => (float[1, 1, H, W] image_embeddings) {{
        image_embeddings = ReduceMean <axes = [1]> (x)
    }}""",
    "sam2": f"""{HEAD} encoder (float[1, 3, {SEEN_SIDE}, {SEEN_SIDE}] input)
        => (float[1, 1, H, W] image_embeddings, float[1, 1, H, W] high_res_features1,
            float[1, 1, H, W] high_res_features2) {{
        image_embeddings = ReduceMean <axes = [1]> (input)
        high_res_features1 = Identity (image_embeddings)
        high_res_features2 = Identity (image_embeddings)
    }}""",
}

MASK_INPUTS = "float[1, 1, 256, 256] mask_input, float[1] has_mask_input"

DECODERS = {
    "efficientsam": (
        "float[1, 1, H, W] image_embeddings, float[1, 1, N, 2] batched_point_coords, "
        "float[1, 1, N] batched_point_labels, int64[2] orig_im_size",
        "batched_point_coords",
        "batched_point_labels",
        "whole = Shape <start = 2> (image_embeddings)",
    ),
    "sam": (
        "float[1, 1, H, W] image_embeddings, float[1, N, 2] point_coords, float[1, N] point_labels, "
        f"{MASK_INPUTS}, float[2] orig_im_size",
        "point_coords",
        "point_labels",
        f"""side = Constant <value = float {{{SEEN_SIDE}.0}}> ()
        longest = ReduceMax <keepdims = 0> (orig_im_size)
        ratio = Div (side, longest)
        exact = Mul (orig_im_size, ratio)
        rounded = Round (exact)
        whole = Cast <to = 7> (rounded)""",
    ),
    "sam2": (
        "float[1, 1, H, W] image_embeddings, float[1, 1, H, W] high_res_features1, "
        "float[1, 1, H, W] high_res_features2, float[1, N, 2] point_coords, float[1, N] point_labels, "
        f"{MASK_INPUTS}, int64[2] orig_im_size",
        "point_coords",
        "point_labels",
        "whole = Shape <start = 2> (image_embeddings)",
    ),
}


def decoder(kind: str) -> str:
    inputs, coords, labels, whole = DECODERS[kind]
    lead = "1, 1, 3" if kind == "efficientsam" else "1, 3"
    dims = f"{lead}, R, C"
    return f"""{HEAD} decoder ({inputs}) => (float[{dims}] masks, float[A, B] ious, float low_res) {{
        zero = Constant <value = float {{0.0}}> ()
        one_axis = Constant <value = int64[1] {{-1}}> ()
        pairs = Constant <value = int64[2] {{-1, 2}}> ()
        places = Reshape ({coords}, pairs)
        marks = Reshape ({labels}, one_axis)
        is_positive = Greater (marks, zero)
        weights = Cast <to = 1> (is_positive)
        column = Unsqueeze (weights, one_axis)
        weighted = Mul (places, column)
        first = Constant <value = int64[1] {{0}}> ()
        all_places = ReduceSum <keepdims = 0> (weighted, first)
        all_weights = ReduceSum <keepdims = 0> (weights)
        middle = Div (all_places, all_weights)
        near = Floor (middle)
        col_row = Cast <to = 7> (near)
        order = Constant <value = int64[2] {{1, 0}}> ()
        at = Gather (col_row, order)
        plane = Squeeze (image_embeddings)
        level = GatherND (plane, at)
        {whole}
        ends = Constant <value = int64[2] {{0, 0}}> ()
        axes = Constant <value = int64[2] {{2, 3}}> ()
        seen = Slice (image_embeddings, ends, whole, axes)
        difference = Sub (seen, level)
        distance = Abs (difference)
        tolerances = Constant <value = float[1, 3, 1, 1] {{0.1, 0.4, 9.0}}> ()
        found = Sub (tolerances, distance)
        factor = Constant <value = float {{40.0}}> ()
        sharp = Mul (found, factor)
        shape = Cast <to = 7> (orig_im_size)
        answers = Constant <value = int64[2] {{1, 3}}> ()
        sizes = Concat <axis = 0> (answers, shape)
        logits = Resize <mode = "linear"> (sharp, , , sizes)
        lead = Constant <value = int64[{lead.count(",") + 1}] {{{lead}}}> ()
        masks_shape = Concat <axis = 0> (lead, shape)
        masks = Reshape (logits, masks_shape)
        ious_flat = Constant <value = float[1, 3] {{0.97, 0.6, 0.3}}> ()
        ious = Identity (ious_flat)
        low_res = Identity (zero)
    }}"""


def write_model(folder: Path, kind: str) -> str:
    """Write a model of a kind, and return its name."""
    onnx = pytest.importorskip("onnx")
    for part, text in (("encoder", ENCODERS[kind]), ("decoder", decoder(kind))):
        onnx.save(onnx.parser.parse_model(text), folder / f"small.{part}.onnx")
    return str(folder)
