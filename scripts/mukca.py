"""Problem files for the real arms of data/mukca."""

from pathlib import Path

MUKCA = Path(__file__).resolve().parents[1] / "data/mukca"
URDFS = {"kuka_14": "iiwa14.urdf", "panda_1": "panda.urdf", "panda_3": "panda.urdf", "dinova_2": "gen3lite.urdf"}
# A ball in a socket: the contact errs, the encoders do not.
NOISE = "[noise]\nencoder_deg = 0\ncontact_mm = 0.2\n"
FULL_MODEL = ("joint_origin", "joint_drift")
COMPLIANCE = ("joint_compliance",)


def placements(robot):
    return sorted(path.name for path in (MUKCA / robot).iterdir() if path.is_dir())


def problem(robot, chosen=None, parameters=FULL_MODEL, base=MUKCA):
    """The text of a problem file: a ball in two sockets of each placement; `base` holds the folders of data/mukca."""
    text = f'[robot]\nurdf = "{base / URDFS[robot]}"\n[tool]\nkind = "ball"\nsigma_mm = 2\n'
    for placement in placements(robot) if chosen is None else chosen:
        for socket in (0, 1):
            text += f'[[fixture]]\nname = "{placement}/{socket}"\nkind = "socket"\nfree = true\n'
            text += f'[[contacts]]\nfile = "{base / robot / placement}/hole_{socket}.csv"\nfixture = "{placement}/{socket}"\n'
        text += f'[[distance]]\nbetween = ["{placement}/0", "{placement}/1"]\nmm = 50\nsigma_mm = 0.05\n'
    quoted = ", ".join(f'"{name}"' for name in parameters)
    return f'{text}[estimate]\nparameters = [{quoted}]\nloss = "geman_mcclure"\nloss_scale = 8\n{NOISE}'
