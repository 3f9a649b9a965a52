"""Faces and features: the JSON of the command, and which face each triangle belongs to."""

import json
import subprocess

import numpy as np
import partscribe


def test_a_box_has_six_faces(box):
    part = partscribe.measure(box, 0.05)
    assert [face["kind"] for face in part.faces] == 6 * ["plane"]
    assert sorted(round(face["area"]) for face in part.faces) == [200, 200, 300, 300, 600, 600]
    assert part.source == "mesh" and part.tolerance == 0.05
    [wall] = part.features  # the thinnest pair of faces
    assert wall["kind"] == "wall" and [(d["name"], d["value"]) for d in wall["dimensions"]] == [("thickness", 10)]


def test_faces_of_triangles_are_a_view(box):
    scan = partscribe.read(box)
    part = partscribe.measure(scan)
    assert part.face_of.shape == (len(scan.triangles),)
    assert not part.face_of.flags.owndata
    assert np.array_equal(np.bincount(part.face_of), 6 * [2])


def test_the_answer_is_that_of_the_command(box, program, tmp_path):
    subprocess.run([program, "measure", box, "--tolerance", "0.05", "--out", tmp_path, "--quiet"], check=True)
    assert partscribe.measure(box, 0.05).json == json.loads((tmp_path / "faces.json").read_text())
