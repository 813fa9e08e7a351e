"""Pictures for a paper: formats, resolution, times and fields that are chosen."""

from myostrain.errors import InputError
from myostrain.output.figures.choice import Choice
from myostrain.output.figures.draw import draw

import numpy as np
import pytest
from PIL import Image
from test_figures import line, sheet

from picture_tools import finish, names, pixels
from small_cases import command_line
from snapshot_files import write_snapshots


def test_formats_and_resolution(tmp_path):
    """Vectors are vectors, and twice the dots per inch are twice the pixels."""
    sheet(tmp_path, n=6)
    finish(tmp_path)
    once = Image.open(draw(tmp_path, Choice(dpi=60, fields=["potential"]))[0]).size
    written = draw(tmp_path, Choice(("pdf", "svg", "png"), 120, fields=["potential", "stress"]))
    stems = [f"{stem}.{suffix}" for stem in ("potential", "stress") for suffix in ("pdf", "svg", "png")]
    assert names(written) == stems
    assert written[0].read_bytes().startswith(b"%PDF")
    assert b"<svg" in written[1].read_bytes()
    np.testing.assert_allclose(Image.open(written[2]).size, np.multiply(once, 2), atol=2)


def test_a_sheet_at_several_times(tmp_path):
    """The wave is where it is at each of them, on the body of that time; there is no film of two times."""
    sheet(tmp_path)
    written = draw(tmp_path, Choice(times=[0.25, 1.0]))
    assert names(written) == ["potential.png", "stress.png", "activation-times.png", "deformation.png"]
    image = pixels(written[0])
    image = image[: int(0.75 * len(image))]  # without the colour bar
    coloured = np.ptp(image, axis=-1) > 40
    half = coloured.shape[1] // 2
    wide, narrow = (np.ptp(np.nonzero(part)[1]) for part in (coloured[:, :half], coloured[:, half:]))
    assert narrow / wide == pytest.approx(0.5 / 0.875, rel=0.05)


def test_fields_of_a_line(tmp_path):
    line(tmp_path, 60)
    assert names(draw(tmp_path, Choice(fields=["recovery", "displacement"]))) == [
        "recovery.png",
        "displacement.png",
    ]


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["--format", "jpg"], "--format: no such format: 'jpg'"),
        (["--format", ""], "--format: give one"),
        (["--dpi", "5000"], "--dpi: 5000: give dots per inch between"),
        (["--times", "a"], "--times: 'a': give numbers"),
        (["--times", "3"], "--times: 3 is not between the first and the last frame, 0 and 1"),
        (["--fields", "potental"], "--fields: there is no 'potental' to draw; did you mean 'potential'"),
        (["--fields", "ecg"], "holds nothing to draw of ecg"),
    ],
)
def test_what_cannot_be_chosen(tmp_path, arguments, words):
    sheet(tmp_path, n=4)
    done = command_line("plot", tmp_path, *arguments)
    assert done.status == 2
    assert words in done.err


def test_what_was_not_written_is_no_picture(tmp_path):
    """Here there is no stress: that is said, and the picture that there is does not hide it."""
    write_snapshots(tmp_path, np.array([[0.0], [1.0]]), [[0, 1]], [0.0], potential=np.zeros((1, 2)))
    with pytest.raises(
        InputError, match="--fields: no field 'stress_trace' was written, which 'stress' shows"
    ):
        draw(tmp_path, Choice(fields=["potential", "stress"]))


def test_a_choice_is_checked():
    with pytest.raises(InputError, match="--format"):
        Choice(formats=["tiff"])


def test_a_style_is_on_top_of_ours(tmp_path):
    """A style of Matplotlib by name or file: the page has its colour, and ours is back afterwards."""
    line(tmp_path, 60)
    finish(tmp_path, {})
    (tmp_path / "mine.mplstyle").write_text("figure.facecolor: 0a141e\n")
    corners = []
    for style in ("", "dark_background", str(tmp_path / "mine.mplstyle"), ""):
        (path, *_) = draw(tmp_path, Choice(dpi=40, fields=["potential"], style=style))
        corners.append(Image.open(path).convert("RGB").getpixel((1, 1)))
    assert corners == [(255, 255, 255), (0, 0, 0), (10, 20, 30), (255, 255, 255)]
    (tmp_path / "bad.mplstyle").write_text("no.such.key: 3\n")
    (tmp_path / "worse.mplstyle").write_bytes(b"\xff\xfe: 3\n")
    for style, words in {
        "dark_backgroud": "no such style .*did you mean 'dark_background'",
        str(tmp_path / "bad.mplstyle"): "bad.mplstyle: no such key; ",
        str(tmp_path / "worse.mplstyle"): "cannot be read as a style of Matplotlib: .*utf-8",
    }.items():
        with pytest.raises(InputError, match=f"--style: .*{words}"):
            Choice(style=style)
