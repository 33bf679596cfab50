"""Points read from a file on a separate thread."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core.formats import load_points
from cpm_core.shapes import Points

MOST = 100_000
"""Largest number of points that can be drawn."""


@dataclass(frozen=True, slots=True)
class PointsRead(Report):
    """Points have been read."""

    path: Path
    points: Points


def read_points(session: Session, path: Path) -> None:
    """Start to read points; the report is `PointsRead` or an error message."""

    def work(task: Task) -> Report:
        positions = load_points(path)
        if len(positions) > MOST:
            message = tr("{name} has {count} points, but no more than {most} can be drawn.")
            raise ValueError(message.format(name=path.name, count=len(positions), most=MOST))
        return PointsRead(path, Points(tuple((row, col) for row, col in positions.tolist())))

    session.tasks.start(tr("Reading {name}…").format(name=path.name), work, tr("reading {name}").format(name=path.name))
