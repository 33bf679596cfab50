"""The outcome of a run in a sentence: what was found, and what Enter will do."""

from __future__ import annotations

from collections.abc import Sequence

from cpm_app.model.state.resolve import describe_contours, describe_skeleton
from cpm_app.model.state.surface_figures import describe_surface
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.session.features.object_commands import describe_doubtful
from cpm_app.session.features.object_rows import ObjectRow
from cpm_app.session.features.object_selection import format_confidence
from cpm_app.session.features.workspace import Workspace
from cpm_core import Skeleton


def describe_outcome(workspace: Workspace) -> str:
    """Describe what has been found and what Enter accepts; empty without proposals before the end of a run."""
    offered = [row for row in workspace.object_list.rows if row.kind == "proposal"]
    if offered:
        return _describe_proposals(workspace, offered)
    status, document = workspace.session.status, workspace.session.document
    if status.phase != "finished" or status.found is None:
        return ""
    if isinstance(status.found, Skeleton):
        found = describe_skeleton(status.found, document.image)
        return f"{found} {insert_keys(tr('{key:export} exports it.'))}" if status.contours else found
    selection, items = workspace.object_selection, document.objects.items
    offered_before = selection.selector is not None and selection.selector.offered
    if items and offered_before and not selection.awaits_offer:  # all of them are accepted or rejected
        return insert_keys(tr("Objects: {count}. {key:export} exports them."), count=len(items))
    found = describe_surface(status.surface) if document.has_volume else describe_contours(status.contours)
    shown = workspace.session.scene.result
    ended = shown is not None and bool(shown.stop_reason)  # what is shown may come from a step before the end
    return f"{found} {describe_lack(workspace)}" if ended and (selection.awaits_offer or not items) else found


def describe_lack(workspace: Workspace) -> str:
    """Describe why there is neither an object nor a proposal, and what to do."""
    session, selection = workspace.session, workspace.object_selection
    status, shown = session.status, session.scene.result
    sentence = status.busy or tr("Nothing yet. Click an object with the Objects tool ({key:objects}), or run.")
    running = status.phase == "running" or (status.started and status.found is None)
    if running or (selection.awaits_offer and not selection.offer_is_known):
        sentence = tr("The objects of the run are still being found.")
    elif shown is not None and shown.stop_reason:
        sentence = tr("No object is offered: click one ({key:objects}).")
        rejected, before = session.document.objects.rejected, session.history.undone_document
        if rejected and selection.selector is not None and selection.selector.offered:
            sentence = tr("All proposals are rejected: click one again ({key:objects}).")
            if before is not None and before.objects.rejected != rejected:
                sentence = tr("All proposals are rejected: undo that ({key:undo}), or click one again ({key:objects}).")
    return insert_keys(sentence)


def _describe_proposals(workspace: Workspace, offered: Sequence[ObjectRow]) -> str:
    """Describe the rows of proposals by how sure they are; empty if something else is selected."""
    listed = workspace.object_list
    accepted = [row for row in listed.rows_to_accept if row.kind == "proposal"]
    if not accepted:
        return describe_doubtful(len(offered)) if listed.pending_rows else ""
    doubtful = len(offered) - len(accepted)
    one = len(accepted) == 1
    if listed.selected_keys:
        sentence = tr("{chosen} of {count} proposals are selected. Enter accepts them · {key:reject}: reject them")
        if one:
            sentence = tr("1 of {count} proposals is selected{likely}. Enter accepts it · {key:reject}: reject it")
    elif doubtful:
        sentence = tr(
            "{count} proposals, {doubtful} doubtful. Enter accepts {chosen} · {key:objects}, click: select · "
            "{key:reject}: reject all"
        )
    elif one:
        sentence = tr("1 proposal{likely}. Enter accepts it · {key:objects}, click: correct · {key:reject}: reject")
    else:
        sentence = tr("{count} proposals. Enter accepts all · {key:objects}, click: select · {key:reject}: reject")
    proposals = {each.key: each.selection for each in workspace.object_selection.proposals}
    first = proposals[accepted[0].key[1]]
    likely, remark = format_confidence(first), translate_core_text(first.remark) if one else ""
    numbers = {"count": len(offered), "chosen": len(accepted), "doubtful": doubtful}
    return " ".join(filter(None, (remark, insert_keys(sentence, **numbers, likely=likely and f", {likely}"))))
