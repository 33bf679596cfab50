"""The larger model that answers clicks in place of the network: chosen in the preferences, fetched on request."""

from __future__ import annotations

from functools import partial

from cpm_app.model.preferences.table import MODEL_FOLDER, MODEL_PREFERENCE, OWN_MODEL, SERVER_ADDRESS, Preference
from cpm_app.model.text.language import tr
from cpm_app.session.features.background import LatestOnlyWorker
from cpm_app.views.window.window import Feature
from cpm_core import MODELS, fetch_model
from cpm_core.objects.prior.larger_models import check_model, is_fetched


class LargerModelFeature(Feature):
    """Uses the model of the preferences as soon as it is on this computer, and offers to fetch it."""

    def set_up(self) -> None:
        """Follow the preferences."""
        self._checker, self._server_checker = (
            LatestOnlyWorker(self.session, name, tr("opening a model")) for name in ("cpm-model", "cpm-server")
        )
        for preference in (MODEL_PREFERENCE, MODEL_FOLDER):
            self.window.preferences.call_on_change(preference, self._on_model_chosen)
        self.window.preferences.call_on_change(SERVER_ADDRESS, self._on_server_named)

    @property
    def _chosen_model(self) -> str:
        name = self._read(MODEL_PREFERENCE)
        return self._read(MODEL_FOLDER) if name == OWN_MODEL else name

    def _read(self, preference: Preference[str]) -> str:
        return self.window.preferences.read_preference(preference)

    def _on_model_chosen(self) -> None:
        """Use the chosen model, or the network until it is here."""
        name = self._chosen_model
        self._use_model("")
        if name in MODELS:
            self._checker.submit(partial(is_fetched, name), partial(self._on_model_known, name))
        elif name:
            self._checker.submit(partial(check_model, name, 2), lambda _: self._on_model_known(name, True))

    def _on_model_known(self, name: str, is_here: bool) -> None:
        if name != self._chosen_model:
            return
        if is_here:
            self._use_model(name)
        else:
            sentence = tr("{model}. Fetch it once? Images stay on this computer.", model=MODELS[name].summary)
            self.window.offers.add_offer(sentence, (tr("Fetch"), partial(self._fetch_model, name)))

    def _fetch_model(self, name: str) -> None:
        self.session.tasks.start_task(
            tr("Fetching {model}…", model=MODELS[name].title),
            lambda task: fetch_model(name, task.advance),
            tr("fetching a model"),
            on_result=lambda _: self._on_model_chosen(),
        )

    def _use_model(self, name: str) -> None:
        self.window.workspace.object_selection.partition_updater.set_model(name, 2)

    def _on_server_named(self) -> None:
        """Let the server of the preferences answer in volumes, if it can."""
        address, updater = self._read(SERVER_ADDRESS), self.window.workspace.object_selection.partition_updater
        updater.set_model("", 3)
        if address:
            self._server_checker.submit(partial(check_model, address, 3), lambda _: updater.set_model(address, 3))
