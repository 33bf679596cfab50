"""A server that speaks the protocol of nnInteractive answers in volumes, and nothing is sent to another one."""

from __future__ import annotations

import json
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest
import scipy

import cpm_core as cpm
from cpm_core.objects import VolumePartition, compute_iou

serialization = pytest.importorskip("nnInteractive.inference.remote.serialization")

INDEX = np.indices((40, 40, 40))
DISTANCE = np.hypot(np.hypot(INDEX[0] - 20.0, INDEX[1] - 18.0), INDEX[2] - 21.0)
RADIUS = 9.3
VALUES = 100.0 * np.clip(RADIUS - DISTANCE + 0.5, 0.0, 1.0)

CAPABILITIES = {
    "supported_interactions": {}, "channel_mapping": {}, "num_interaction_channels": 7, "supports_initial_label": True,
    "supports_zero_shot_label_refinement": False, "preferred_scribble_thickness": 1, "interaction_decay": 1.0,
    "inference_session_version": 1,
}  # fmt: skip


class Handler(BaseHTTPRequestHandler):
    """Answers with the bright voxels that are connected to a positive point or scribble, less negative ones."""

    def do_GET(self) -> None:
        self.reply(CAPABILITIES)

    def do_POST(self) -> None:
        asked, body = self.path.strip("/"), self.rfile.read(int(self.headers.get("Content-Length", 0)))
        server, facts = self.server, {}
        server.asked.append(asked)
        if asked == "claim":
            facts = {"lease_token": f"lease {server.asked.count('claim')}"}
        elif server.expired and asked != "release":
            server.expired = False
            self.reply({"detail": "lease expired"}, status=410)
            return
        elif asked == "set_image":
            server.image = serialization.unpack_array(body)[0]
            facts = {"original_image_shape": server.image.shape}
        elif asked == "reset_interactions":
            server.marks = []
        elif asked == "add_point_interaction":
            given = json.loads(body)
            server.marks.append((np.array([given["coordinates"]]), given["include_interaction"]))
        elif asked == "add_bbox_interaction":
            given = json.loads(body)
            server.boxes.append(given["bbox_coords"])
            middle = np.mean(given["bbox_coords"], axis=1).astype(int)
            server.marks.append((middle[None], given["include_interaction"]))
        elif asked in ("add_scribble_interaction", "add_lasso_interaction"):
            given = json.loads(self.headers["X-Meta"])
            server.drawn = serialization.unpack_array(body)
            server.marks.append((np.argwhere(server.drawn), given["include_interaction"]))
        elif asked == "predict":
            parts, _ = scipy.ndimage.label(server.image > 50.0)
            held = np.unique([np.bincount(parts[tuple(at.T)]).argmax() for at, adds in server.marks if adds])
            found = np.isin(parts, held[held > 0]).astype(np.uint8)
            meta = {"ran_prediction": True, "bbox": [[0, side] for side in found.shape]}
            self.reply(meta, serialization.pack_array(found))
            return
        self.reply(facts)

    def reply(self, facts: dict, content: bytes | None = None, status: int = 200) -> None:
        plain = json.dumps(facts)
        body = plain.encode() if content is None else content
        self.send_response(status)
        self.send_header("X-Meta", plain)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Say nothing."""


@pytest.fixture
def server():
    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as made:
        made.asked, made.expired, made.marks, made.boxes = [], False, [], []
        made.address = f"http://127.0.0.1:{made.server_address[1]}"
        thread = threading.Thread(target=made.serve_forever, args=(0.01,))
        thread.start()
        yield made
        made.shutdown()
        thread.join()


def test_points_and_scribbles_select_a_body_whose_surface_is_exact(server) -> None:
    volume = VolumePartition(cpm.Image(VALUES), model=server.address)
    assert server.asked == []
    found = volume.select([(20, 18, 21)])
    assert compute_iou(found.mask, DISTANCE < RADIUS) > 0.95
    away = np.linalg.norm(found.surface.vertices - [20.0, 18.0, 21.0], axis=1) - RADIUS
    assert np.abs(away).mean() < 0.3
    assert found.model == server.address.removeprefix("http://")
    drawn = volume.select([(20.0, 18.0, col) for col in np.linspace(15, 27, 25)])
    assert server.asked.count("set_image") == 1 and "add_scribble_interaction" in server.asked
    assert compute_iou(drawn.mask, found.mask) > 0.95
    del volume
    assert server.asked[-1] == "release"


@pytest.mark.parametrize("axis", range(3))
def test_a_closed_line_in_a_slice_is_sent_as_a_lasso_with_what_it_encloses_and_clicks_beside_it_as_points(
    server, axis
) -> None:
    volume = VolumePartition(cpm.Image(VALUES), model=server.address)
    turns, center = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False), np.array([20.0, 18.0, 21.0])
    line = np.tile(center, (24, 1))
    across = [at for at in range(3) if at != axis]
    line[:, across] += 11.0 * np.column_stack([np.cos(turns), np.sin(turns)])
    found = volume.select(line)
    assert "add_lasso_interaction" in server.asked and "add_scribble_interaction" not in server.asked
    area = np.moveaxis(server.drawn, axis, 0)
    assert area[int(center[axis])].sum() == area.sum() == pytest.approx(np.pi * 11.0**2, rel=0.15)
    assert compute_iou(found.mask & (DISTANCE < RADIUS), DISTANCE < RADIUS) > 0.9
    beside = center.copy()
    beside[across] -= 14.0
    for click in ([20.0, 18.0, 30.0], beside.tolist()):
        volume.select([click], previous=found)
        assert server.asked[-3:-1] == ["add_lasso_interaction", "add_point_interaction"]
        assert server.marks[-1][0].tolist() == [click]


def test_a_box_goes_to_the_server_as_its_middle_slices_and_nowhere_else(server) -> None:
    volume = VolumePartition(cpm.Image(VALUES), model=server.address)
    found = volume.select(box=[(10, 8, 31), (30, 28, 11)])
    assert server.boxes == [
        [[20, 21], [8, 29], [11, 32]],
        [[10, 31], [18, 19], [11, 32]],
        [[10, 31], [8, 29], [21, 22]],
    ]
    assert compute_iou(found.mask, DISTANCE < RADIUS) > 0.95
    volume.select(box=[(20, 8, 11), (20, 28, 31)])
    assert server.boxes[3:] == [[[20, 21], [8, 29], [11, 32]]]
    with pytest.raises(ValueError, match="for a server of nnInteractive"):
        VolumePartition(cpm.Image(VALUES)).select(box=[(10, 8, 11), (30, 28, 31)])


def test_clicks_correct_the_answer_and_limits_hold(server) -> None:
    volume = VolumePartition(cpm.Image(VALUES), model=server.address)
    first = volume.select([(20, 18, 21)])
    less = volume.select([(20, 18, 21)], [(20, 18, 27)], previous=first)
    assert first.mask[20, 18, 27] and not less.mask[20, 18, 27]
    assert not volume.select([(20, 18, 21)], excluded=INDEX[0] > 20).mask[21:].any()
    assert not volume.select([(2, 2, 2)]).has_boundary


def test_an_expired_session_is_opened_again(server) -> None:
    volume = VolumePartition(cpm.Image(VALUES), model=server.address)
    before = volume.select([(20, 18, 21)])
    server.expired = True
    assert (volume.select([(20, 18, 22)]).mask == before.mask).mean() > 0.999
    assert server.asked.count("set_image") == 2


def test_a_server_that_does_not_answer_and_one_for_an_image_say_so() -> None:
    with pytest.raises(ValueError, match=r"The server http://127\.0\.0\.1:9 does not answer: "):
        VolumePartition(cpm.Image(VALUES), model="http://127.0.0.1:9").select([(20, 18, 21)])
    with pytest.raises(ValueError, match="answers in volumes, not in images"):
        cpm.partition(VALUES[20], model="http://127.0.0.1:9")
