"""Files for wrong inputs: whole ones, and what becomes of them by a slip of the hand or of the disk."""

from __future__ import annotations

import shutil
from pathlib import Path

from pipenav_hardware.arm_config import ScannerConfig, arm_toml, default_arm

from pipenav.robots.robot import load_robot
from pipenav.storage.shipped import policies_dir

EARLIER = Path(__file__).resolve().parents[1] / "data" / "0.1"

CORNER = 'angle_deg = 90\nturn = "left"\nstraight_mm = 900\n'

WHOLE = {
    "route.toml": f"schema = 2\ndiameter_mm = 100\nfirst_straight_mm = 800\n\n[[corners]]\n{CORNER}",
    "corners.toml": 'description = "some"\ndiameters_mm = [100, 110]\n'
    "angles_deg = { start = 60, stop = 90, step = 10 }\n",
    "routes.toml": 'schema = 1\ndescription = "some"\nruns = 2\nseed = 1\ncorners = 2\ndiameters_mm = [100]\n'
    "angles_deg = [90]\nstraights_mm = [600]\nends_mm = 1000\n",
    "s-bends.toml": 's_bend = true\ndescription = "some"\ndiameters_mm = [100]\nangles_deg = [135]\n'
    "bend_radii_d = [1.5]\n",
    "reducers.toml": 'description = "some"\nreducers_mm = [[100, 80]]\nlengths_d = [1.0]\n',
    "disturb.toml": "noise = [0.0, 0.01]\nlatency = [1, 1]\n",
    "recipe.toml": 'pipes = ["d=100,angle=90"]\nsteps = 64\n\n[learner]\n'
    "robots = 2\nrollout_steps = 2\nbatch_size = 4\n",
    "faults.json": '[{"fault": "drop", "probability": 0.1}]\n',
    "town.csv": "x1,y1,x2,y2,bore\n0,0,90,0,100\n90,0,90,80,100\n",
    "town.inp": "[JUNCTIONS]\nA 0\nB 0\n[PIPES]\nP A B 90 100\n[OPTIONS]\nUnits LPS\n[COORDINATES]\nA 0 0\nB 90 0\n",
    "words.txt": "dear diary\n",
}
"""Texts of valid files, by name; `words.txt` is valid as what it is."""

EDITS = {
    "route.toml": {
        "newer": ("schema = 2", "schema = 9"),
        "quoted-schema": ("schema = 2", 'schema = "2"'),
        "no-schema": ("schema = 2", ""),
        "extra": ("schema = 2", "schema = 2\ndiametre_mm = 100"),
        "metres": ("diameter_mm = 100", "diameter_mm = 0.1"),
        "unit": ("diameter_mm = 100", 'diameter_mm = "100mm"'),
        "nan": ("first_straight_mm = 800", "first_straight_mm = nan"),
        "thin": ("schema = 2", "schema = 2\nwall_mm = 0"),
        "short": ("straight_mm = 900", "straight_mm = 20"),
        "up": ('"left"', '"up"'),
        "text-angle": ("angle_deg = 90", 'angle_deg = "sharp"'),
        "no-angle": ("angle_deg = 90\n", ""),
        "sharp": ("angle_deg = 90", "angle_deg = 10"),
        "rolled": ("straight_mm = 900", "straight_mm = 900\nroll_deg = 720"),
        "tight": ("straight_mm = 900", "straight_mm = 900\nbend_radius_mm = 20"),
        "bend-text": ("straight_mm = 900", 'straight_mm = 900\nbend_radius_mm = "1.5D"'),
        "corner-extra": ("straight_mm = 900", "straight_mm = 900\nradius_mm = 150"),
        "turning-reducer": ("straight_mm = 900", "straight_mm = 900\nto_diameter_mm = 80"),
        "lost-length": ("straight_mm = 900", "straight_mm = 900\nlength_mm = 80"),
        "wide-reducer": (CORNER, "to_diameter_mm = 800\n"),
        "long-reducer": (CORNER, "to_diameter_mm = 80\nlength_mm = -5\n"),
        "no-corner": (f"[[corners]]\n{CORNER}", "corners = []"),
        "one-corner": ("[[corners]]", "[corners]"),
        "many": (f"[[corners]]\n{CORNER}", f"[[corners]]\n{CORNER}" * 51),
        "knot": (f"[[corners]]\n{CORNER}", f"[[corners]]\n{CORNER}" * 4),
    },
    "corners.toml": {
        "newer": ("description", "schema = 9\ndescription"),
        "extra": ("diameters_mm", "diameter_mm"),
        "uneven": ("step = 10", "step = 7"),
        "backwards": ("start = 60", "start = 120"),
        "no-step": (", step = 10", ""),
        "none": ("[100, 110]", "[]"),
        "one": ("[100, 110]", "100"),
        "nan": ("[100, 110]", "[nan]"),
        "wide": ("[100, 110]", "[1000]"),
        "turned": ("diameters_mm", 'turns = ["up"]\ndiameters_mm'),
        "bent-twice": ("diameters_mm", "bend_radius_mm = 100\nbend_radii_d = [1]\ndiameters_mm"),
        "bent-negative": ("diameters_mm", "bend_radii_d = [-1]\ndiameters_mm"),
    },
    "routes.toml": {
        "newer": ("schema = 1", "schema = 9"),
        "extra": ("seed = 1", "seed = 1\nlenghts = 3"),
        "none": ("runs = 2", "runs = 0"),
        "many": ("runs = 2", "runs = 100000"),
        "seed": ("seed = 1", "seed = 1.5"),
        "no-ends": ("ends_mm = 1000\n", ""),
        "short-ends": ("ends_mm = 1000", "ends_mm = 10"),
        "tight": ("ends_mm", "bend_radii_d = [0.2]\nends_mm"),
        "knotted": ("corners = 2", "corners = 40"),
    },
    "s-bends.toml": {
        "false": ("s_bend = true", "s_bend = false"),
        "near": ("s_bend = true", "s_bend = true\nbetween_mm = 10"),
        "tight": ("[1.5]", "[0.2]"),
        "extra": ("description", "between = 100\ndescription"),
    },
    "reducers.toml": {
        "single": ("[[100, 80]]", "[100, 80]"),
        "three": ("[[100, 80]]", "[[100, 80, 60]]"),
        "none": ("[[100, 80]]", "[]"),
        "wide": ("[[100, 80]]", "[[100, 800]]"),
        "negative": ("[1.0]", "[-1.0]"),
        "extra": ("lengths_d", "length_d"),
        "short-ends": ("lengths_d", "ends_mm = 5\nlengths_d"),
    },
    "disturb.toml": {
        "extra": ("noise", "niose"),
        "backwards": ("[0.0, 0.01]", "[0.01, 0.0]"),
        "negative": ("[0.0, 0.01]", "-0.1"),
        "three": ("[0.0, 0.01]", "[0, 1, 2]"),
        "half-step": ("[1, 1]", "[1, 1.5]"),
        "text": ("[1, 1]", '"1 step"'),
        "nan": ("[0.0, 0.01]", "[nan, nan]"),
        "one": ("[1, 1]", "1"),
    },
    "recipe.toml": {
        "extra": ("steps", "stepps"),
        "deep-extra": ("robots = 2", "robot = 2"),
        "no-steps": ("steps = 64", "steps = 0"),
        "text": ("steps = 64", 'steps = "many"'),
        "batch": ("batch_size = 4", "batch_size = 3"),
        "extends": ("pipes", 'extends = "arms"\npipes'),
        "extends-other": ("pipes", 'extends = "pirate"\npipes'),
        "extends-number": ("pipes", "extends = 1\npipes"),
        "flat": ("[learner]\n", "learner = 3\n"),
        "twice": ("steps = 64", "steps = 64\nsteps = 65"),
    },
    "town.csv": {
        "nan": ("90,80", "nan,80"),
        "zero": ("80,100", "80,0"),
        "mixed": ("80,100", "80,4 in"),
        "short": ("90,80,100", "90"),
        "no-columns": ("x1", "from"),
    },
    "town.inp": {
        "twice": ("B 0\n", "A 0\n"),
        "one-place": ("B 90 0", "B 0 0"),
        "zero": ("90 100", "90 0"),
        "nan": ("B 90", "B nan"),
        "nowhere": ("P A B", "P A C"),
        "units": ("LPS", "XYZ"),
        "empty": ("P A B 90 100\n", ""),
    },
    "faults.json": {
        "unknown": ('"drop"', '"drops"'),
        "object": ('[{"fault": "drop", "probability": 0.1}]', '{"fault": "drop"}'),
        "extra": ('"probability"', '"chance"'),
        "sure": ("0.1", "1.5"),
        "number": ('[{"fault": "drop", "probability": 0.1}]', "[3]"),
    },
    "robot.toml": {
        "newer": ("schema_version = 2", "schema_version = 9"),
        "extra": ("schema_version = 2", "schema_version = 2\ncolour = 1"),
        "no-name": ('name = "basic"\n', ""),
        "negative": ("mass = 0.10", "mass = -0.10"),
        "nan": ("mass = 0.10", "mass = nan"),
        "stranger": ('like = "box"', 'like = "bax"'),
        "backwards": ("lower = -2.4", "lower = 2.5"),
    },
    "arm.toml": {
        "newer": ("schema_version = 1", "schema_version = 9"),
        "extra": ("schema_version = 1", "schema_version = 1\nbuad = 1"),
        "stranger": ('robot = "real-setup"', 'robot = "basic"'),
        "nobody": ('robot = "real-setup"', 'robot = "my-arm"'),
        "slow": ("baud = 1000000", "baud = 12345"),
        "same-id": ("id = 2", "id = 1"),
        "sign": ("sign = 1", "sign = 2"),
        "portless": ('port = "/dev/ttyNONE0"\n', ""),
    },
    "front.csv": {
        "newer": ('"schema": 1', '"schema": 9'),
        "nobody": ('"robot": "basic"', '"robot": "my-arm"'),
        "headless": ("# pipenav-trajectory ", ""),
        "columns": ("theta1_rad", "theta9_rad"),
        "comma": ("0.1,", '"0,1",'),
    },
    "mission/telemetry.jsonl": {
        "newer": ('"pipenav_telemetry": 1', '"pipenav_telemetry": 9'),
        "headless": ('{"pipenav_telemetry"', '{"telemetry"'),
    },
    "training/config.json": {"extra": ('"steps"', '"stepps"')},
    "evaluation/eval.json": {"newer": ('"schema": 1', '"schema": 9')},
    "my-run/run.json": {"newer": ('"schema": 1', '"schema": 9')},
}
"""Slips in valid files: name of the slip, the text, and what stands in its place. The file is called `SLIP-NAME`."""

CUT, EMPTY, NOISE, CRUMB = "cut", "empty", "noise", bytes(range(256)) * 4


def prepare(folder: Path) -> None:
    """Write all files, whole and wrong, and the folders that commands of an earlier version made."""
    shutil.copytree(EARLIER, folder, dirs_exist_ok=True)
    for name, text in WHOLE.items():
        (folder / name).write_text(text)
    shutil.copyfile(policies_dir().parent / "robots" / "basic" / "robot.toml", folder / "robot.toml")
    shutil.copyfile(policies_dir() / "arm" / "best.zip", folder / "best.zip")
    scanner = ScannerConfig(driver="scip2", port="/dev/ttyNONE1")
    (folder / "arm.toml").write_text(arm_toml(default_arm(load_robot("real-setup"), "/dev/ttyNONE0", scanner, None)))
    for name, edits in EDITS.items():
        content = (folder / name).read_bytes()
        for slip, text in {CUT: content[: len(content) * 3 // 5], EMPTY: b"", NOISE: CRUMB}.items():
            _beside(folder / name, slip).write_bytes(text)
        for slip, (old, new) in edits.items():
            assert old in content.decode(), f"{old!r} is not in {name}"
            _beside(folder / name, slip).write_text(content.decode().replace(old, new))
    _prepare_folders(folder / "folders")
    for slip, text in {CUT: (folder / "best.zip").read_bytes()[:9000], EMPTY: b"", NOISE: CRUMB}.items():
        (folder / f"{slip}-best.zip").write_bytes(text)


def _prepare_folders(folder: Path) -> None:
    """Folders in whose places files are wanted, foreign ones with a pipe's name, and damaged ones."""
    for name in ("folder.toml", "folder.zip", "folder.png", "my-run", "corner-d90-a60-left"):
        (folder / name).mkdir(parents=True)
        (folder / name / "mine.txt").write_text("keep this")
    (folder / "corner-d90-a60-right").write_text("a file")
    shutil.copytree(folder.parent / "evaluation", folder / "newer")
    (folder / "newer" / "newer-eval.json").replace(folder / "newer" / "eval.json")
    shutil.copytree(folder.parent / "training", folder / "extra")
    (folder / "extra" / "extra-config.json").replace(folder / "extra" / "config.json")
    shutil.copyfile(folder.parent / "mission" / "telemetry.jsonl", folder / "telemetry.jsonl")


def _beside(path: Path, slip: str) -> Path:
    return path.with_name(f"{slip}-{path.name}")
