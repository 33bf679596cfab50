"""What users expect of such a program, where it is, and the test that shows it."""

from __future__ import annotations

from typing import NamedTuple

from docs.making.tables import table as made


class Row(NamedTuple):
    """An expectation: what it is, where the program has it, and a test, as path::name."""

    what: str
    where: str
    test: str


_IMAGES, _CONTOURS, _CLI = "tests/core/formats/images", "tests/core/formats/contours", "tests/core/cli"

ROWS = (
    Row("Pictures of common kinds are opened, with all their bits", "Ctrl+O, drop, `cpm run`, `load_image`",
        f"{_IMAGES}/test_raster.py::test_sixteen_bit_grey_is_kept_as_it_is"),
    Row("Stacks, channels and times are opened", "File, Choose part of the file; `--page`, `--channel`, `--time`",
        f"{_IMAGES}/test_stacks.py::test_hyperstacks_give_every_channel_and_time_with_sizes"),
    Row("Medical files are opened, and results lie where the image lies", "DICOM, NIfTI, NRRD, MetaImage",
        f"{_IMAGES}/test_nifti.py::test_a_label_volume_has_the_affine_of_the_file_that_was_read"),
    Row("The size of a pixel is read, shown, and used in tables", "scale bar, tables, `--pixel-size`",
        f"{_CLI}/test_cli.py::test_the_size_of_a_pixel_goes_from_the_image_into_the_table"),
    Row("Color images are taken by a stated rule", "the channel above the sliders, `--channel`, `Image(color=...)`",
        "tests/library/test_color_arrays.py::test_an_array_has_the_gray_levels_of_its_file"),
    Row("A damaged file is refused in one sentence", "the message line, standard error, `ValueError`",
        "tests/core/cli/test_bad_input.py::test_bad_input_is_one_line_on_standard_error_and_nothing_is_written"),
    Row("Drawings for graphics programs and CAD", "Ctrl+E: SVG, DXF with its unit",
        f"{_CONTOURS}/test_dxf.py::test_polylines_run_through_the_contours_the_right_way_up_in_the_unit_of_the_image"),
    Row("Selections and annotations for ImageJ, Fiji and QuPath", "Ctrl+E: `.zip`, `.roi`, GeoJSON",
        f"{_CONTOURS}/test_imagej.py::test_the_set_holds_all_contours_in_their_order_under_their_names"),
    Row("Annotations for training", "Ctrl+E: COCO, labelme",
        f"{_CONTOURS}/test_annotations.py::test_coco_has_an_instance_of_each_closed_contour_in_the_category_of_its_name"),
    Row("Label masks of the image's size", "Ctrl+E: PNG, TIFF, NIfTI; `Result.labels`",
        "tests/library/test_region_table.py::test_holes_of_chosen_objects_are_kept_out_of_their_labels"),
    Row("Measurements as a table, with the usual names", "Ctrl+T, `.measures.csv`, `Result.table`",
        "tests/library/test_region_table.py::test_large_regions_have_the_measures_that_scikit_image_finds_in_their_label_mask"),
    Row("Everything that is written can be read back",
        "`load_contours`, `load_surface`, `load_centerlines`; File, Import; `cpm export`",
        "tests/core/formats/contours/test_round_trip.py::test_every_format_of_contours_in_a_plane_is_read_back"),
    Row("What other programs write is read", "ImageJ, QuPath, labelme, COCO, SVG, DXF",
        f"{_CONTOURS}/test_other_programs.py::test_all_shapes_of_labelme_are_read"),
    Row("Figures for publications, with a scale bar", "Ctrl+E: `.figure.svg`, PDF, PNG; `cpm export`, `plot`",
        "tests/app/views/export/test_export.py::test_a_figure_shows_image_contours_and_a_scale_bar"),
    Row("The run as an animation", "Ctrl+E: GIF, APNG, MP4",
        "tests/core/formats/test_animation.py::test_all_frames_are_there_for_their_time"),
    Row("The clipboard", "Ctrl+C, Ctrl+V",
        "tests/app/session/test_saving.py::test_contours_are_copied_in_all_formats_at_once_and_as_a_table"),
    Row("Every file states how it was made", "provenance in every format",
        "tests/core/formats/test_provenance.py::test_every_format_tells_how_its_contours_were_found"),
    Row("Everything can be undone", "Ctrl+Z",
        "tests/app/views/tools/test_tools.py::test_each_gesture_is_one_step_of_undo_named_in_the_menu"),
    Row("Work is saved in a session, with its runs", "Ctrl+S",
        "tests/app/session/test_saving.py::test_what_is_saved_by_a_key_is_restored_with_objects_and_view"),
    Row("Nothing is lost in a crash", "the next start offers it",
        "tests/app/session/test_recovery.py::test_a_change_is_in_the_journal_a_moment_later_by_itself"),
    Row("Recent work and samples are at hand", "the start screen, Alt+Home",
        "tests/app/views/files/test_start_screen.py::test_recent_work_is_opened_by_keys_alone"),
    Row("Help that leads through whole tasks", "F1, menu Help",
        "tests/app/views/window/test_guide.py::test_every_action_that_is_named_exists"),
    Row("Everything can be done by keys, which can be changed", "`?` shows them, Ctrl+comma changes them",
        "tests/e2e/test_by_keys_alone.py::test_the_main_job_is_done_by_keys_alone"),
    Row("The window speaks other languages", "Ctrl+comma",
        "tests/app/model/test_language.py::test_a_window_in_a_made_up_language_shows_nothing_that_is_not_translated"),
    Row("A click selects an object, closed across gaps", "the tool Objects, `partition`, `--object`",
        "tests/core/objects/test_partition.py::test_a_click_in_a_disk_gives_the_disk"),
    Row("Objects are clicked in a notebook", "`view`",
        "tests/core/notebook/test_view.py::test_clicks_choose_select_correct_and_remove"),
    Row("Outlines can be mended by hand", "the tool Mend",
        "tests/app/views/tools/test_mend_tool.py::test_a_boundary_is_pulled_onto_the_edge_in_one_step_of_undo"),
    Row("Results are compared with a truth", "Ctrl+D, `compare`",
        "tests/app/views/panels/test_truth.py::test_a_shifted_disc_has_the_overlap_and_the_distances_of_geometry"),
    Row("Other methods can be tried on the same image", "`cpm compare`",
        f"{_CLI}/test_cli_compare.py::test_methods_are_told_in_the_order_in_which_they_are_named_with_a_table"),
    Row("Volumes: surfaces, slices, a view in space", "a volume is opened like an image, `--sphere`",
        f"{_CLI}/test_cli_volume.py::test_every_start_leads_to_the_surface"),
    Row("Stacks page by page, with objects followed", "Run all pages, `--pages all --follow`, `follow`",
        "tests/core/pages/test_follow.py::test_a_disk_that_moves_and_grows_is_one_track_with_its_area_on_every_page"),
    Row("Many images at once, in processes or on a cluster", "`cpm batch`",
        f"{_CLI}/test_cli_session.py::test_a_batch_does_to_each_image_what_a_run_does_and_reports_a_bad_one"),
    Row("A command line for scripts, with JSON", "`cpm run --json`",
        f"{_CLI}/test_cli.py::test_run_finds_the_disk_and_tells_it_as_json"),
    Row("It installs as a wheel that runs outside its checkout", "`pip install`, `pipx`, `uvx`",
        "tests/packages/test_distributions.py::test_the_window_of_the_wheel_finds_its_pictures_samples_and_languages"),
    Row("A library, with an example for every name", "`import cpm_core`",
        "tests/library/test_examples.py::test_the_examples_give_what_they_say"),
    Row("A plugin for napari", "`pip install '.[napari]'`",
        "tests/e2e/test_napari.py::test_napari_reads_writes_and_finds_by_the_plugin_without_the_window"),
    Row("It can be extended: formats, tools, layers, methods, parameters", "`ARCHITECTURE.md`",
        "tests/app/test_extending.py::test_a_method_is_a_class_that_the_window_runs_without_knowing_it"),
    Row("It installs from stated dependencies, under licenses that allow any use", "`pyproject.toml`",
        "tests/supply/test_requirements.py::test_nothing_that_is_installed_for_the_program_is_under_the_gpl_alone"),
)  # fmt: skip
"""The expectations, 37 in number."""


def table() -> str:
    """All of them."""
    lines = ((str(number), row.what, row.where, f"`{row.test}`") for number, row in enumerate(ROWS, start=1))
    return made(("", "what users expect", "where", "shown by"), lines)
