"""The edges of the image, for lines that follow them at once."""

from __future__ import annotations

from dataclasses import dataclass

from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.worker.commands.run import Command, CommandContext
from cpm_core.field.scale_field import ScaleField
from cpm_core.model.image_fields import ImageFields
from cpm_core.parameters import Parameters

EDGES = "edges"
"""Topic of the messages on trouble with the edges."""


@dataclass(frozen=True, eq=False, slots=True)
class EdgesFound(Report):
    """Fields of the image opened as `image_generation`, at its full size."""

    image_generation: int
    scale_field: ScaleField


@dataclass(frozen=True, slots=True)
class FindEdges(Command):
    """Report the fields of the image, if it is still the current one."""

    image_generation: int
    parameters: Parameters

    latest_only = True
    activity = tr("looking for edges")
    topic = EDGES

    def execute(self, context: CommandContext) -> None:
        """Find them, unless the method has none."""
        fields: object = context.run.method
        if self.image_generation == context.run.image_generation and isinstance(fields, ImageFields):
            context.report(EdgesFound(self.image_generation, fields.scale_field(self.parameters)))
