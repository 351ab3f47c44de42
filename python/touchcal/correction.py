"""Corrects joint positions by a calibration's ``correction.json``.

A URDF holds joint origins; it cannot say that an encoder errs with its position, or that a joint deflects under a torque.
``correction.json``, beside ``calibrated.urdf``, does::

    correction = Correction.read("out/correction.json")
    q = correction.true_positions(measured)         # positions for calibrated.urdf
    command = correction.commanded_positions(plan)  # of positions that were planned with calibrated.urdf

This file needs Python 3.10 and numpy alone, and nothing else of touchcal: it may be copied. The same for C++ is
``include/touchcal/correction.hpp``.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["Correction", "CorrectionError"]

_Floats = npt.NDArray[np.float64]

_SCHEMA = 1
_REST_ITERATIONS = 50
_AT_REST = 1e-13
_NEWTON_STEPS = 50
_CONVERGED = 1e-14
_MOST_TURNS = 2
_NO_COMMAND = "what the joints deflect by is not known before the arm is there, so that nothing can be commanded"


class CorrectionError(ValueError):
    """The file is not what it should be, or positions have no correction."""


@dataclass(frozen=True)
class _Link:
    """What moves with a joint, or the tip."""

    translation: _Floats
    rotation: _Floats
    mass: float
    center: _Floats


@dataclass(frozen=True)
class _Joint:
    turns: bool
    gear_ratio: float
    harmonics: tuple[tuple[int, float, float], ...]
    compliance: float
    backlash: float
    axis: _Floats
    link: _Link

    def deflects(self) -> bool:
        """Whether any torque moves the joint."""
        return self.compliance != 0.0 or self.backlash != 0.0

    def deflection(self, torque: float, backlash_torque: float) -> float:
        """How far ``torque`` moves the joint."""
        return self.compliance * torque + self.backlash * torque / math.hypot(torque, backlash_torque)

    def error(self, q: float) -> float:
        """Measured less true position where the encoder measures ``q``."""
        harmonics = sum(a * math.sin(n * q) + b * math.cos(n * q) for n, a, b in self.harmonics)
        return harmonics - self.gear_ratio * q

    def slope(self, q: float) -> float:
        """Derivative of the error by ``q``."""
        harmonics = sum(n * (a * math.cos(n * q) - b * math.sin(n * q)) for n, a, b in self.harmonics)
        return harmonics - self.gear_ratio

    def measured(self, q: float) -> float:
        """The position that the encoder measures at ``q``, by Newton's method."""
        measured = q
        for _ in range(_NEWTON_STEPS):
            remaining = 1.0 - self.slope(measured)
            if not remaining > 0.0:
                break
            step = (measured - self.error(measured) - q) / remaining
            measured -= step
            if abs(step) <= _CONVERGED * max(1.0, abs(measured)):
                return measured
        raise CorrectionError(f"no measured position belongs to {q}: the encoder's errors are too large")


class Correction:
    """Corrections of the positions of an arm's joints: rad, or m for a prismatic joint, base first.

    Positions of revolute joints beyond two turns are refused, since they look like degrees.
    A ``load`` is the wrench fx, fy, fz, tx, ty, tz (N, N m) that is exerted on the tip about its origin, in its frame.
    ``tau`` are the measured torques (N m, or N of a prismatic joint) that gravity and contact exert about the joints, the
    negative of what the motors exert: where compliances belong to them (``has_measured_torques``) they are needed, and no
    load is taken; elsewhere they are refused.

    Args:
        text: the content of ``correction.json``.
        not_usable: read that of a calibration that must not be used, too.

    Attributes:
        status: of the calibration, "usable", "doubtful" or "not_usable".
        names: of the joints.
        offsets: of the encoders, measured less true, which ``calibrated.urdf`` contains.
        has_measured_torques: whether joints deflect by measured torques, in place of those of gravity and a load.

    Raises:
        CorrectionError: the text is not that of such a file, or of a calibration that must not be used.
    """

    def __init__(self, text: str, *, not_usable: bool = False) -> None:
        try:
            content = json.loads(text, parse_constant=_refuse)
            _expect(content["schema"] == _SCHEMA, f"schema {_SCHEMA} of correction.json, found {content['schema']!r}")
            status = content["status"]
            _expect(status in ("usable", "doubtful", "not_usable"), f"a status, found {status!r}")
            _expect(not_usable or status != "not_usable", "a calibration that may be used, found status not_usable")
            self.status: str = status
            self.names: list[str] = [_text(joint["name"]) for joint in content["joints"]]
            self.offsets: _Floats = np.array([_number(joint["offset_in_urdf"]) for joint in content["joints"]])
            torque = content["torque"]
            _expect(torque in ("gravity_and_load", "measured"), f"a kind of torque, found {torque!r}")
            self.has_measured_torques: bool = torque == "measured"
            self._backlash_torque = _number(content["backlash_torque"])
            _expect(self._backlash_torque > 0.0, f"a torque above 0, found {self._backlash_torque}")
            self._gravity = _vector(content["gravity_m_s2"], 3)
            self._joints = [_joint(joint) for joint in content["joints"]]
            self._tip = _link(content["tip_link"])
        except (json.JSONDecodeError, KeyError, TypeError, RecursionError, OverflowError) as error:
            message = f"not the text of a correction.json (Correction.read takes its path): {type(error).__name__}: {error}"
            raise CorrectionError(message) from error
        _expect(len(self._joints) > 0, "at least one joint, found none")
        self._is_compliant = any(joint.deflects() for joint in self._joints)

    @staticmethod
    def read(path: str | Path, *, not_usable: bool = False) -> Correction:
        """Reads the file, as ``Correction`` does its text. Where there is none, positions need no correction."""
        return Correction(Path(path).read_text(encoding="utf-8"), not_usable=not_usable)

    def true_positions(
        self, measured: npt.ArrayLike, load: npt.ArrayLike | None = None, *, tau: npt.ArrayLike | None = None
    ) -> _Floats:
        """Positions for ``calibrated.urdf`` where the encoders measure ``measured``: one for each joint (rad or m)."""
        q = self._positions(measured)
        load = None if load is None else _vector(load, 6)
        stiff = np.array([q - joint.error(q) for joint, q in zip(self._joints, q.tolist())])
        if not self._is_compliant:
            return stiff
        if self.has_measured_torques:
            if tau is None or load is not None:
                raise CorrectionError("expected `tau`, measured torques of the joints, and no `load`")
            return stiff + self._deflections(_vector(tau, len(self._joints)))
        _expect(tau is None, "no `tau`: the joints of this file deflect by gravity and `load`")
        positions = stiff
        for _ in range(_REST_ITERATIONS):
            deflected = stiff + self._deflections(self._torques(positions, load))
            change = float(np.max(np.abs(deflected - positions)))
            positions = deflected
            if change <= _AT_REST:
                return positions
        raise CorrectionError("the joints do not come to rest: they are too compliant for what they carry")

    def commanded_positions(self, wanted: npt.ArrayLike, load: npt.ArrayLike | None = None) -> _Floats:
        """Positions to command so that the joints are at ``wanted``, positions of ``calibrated.urdf``, one for each joint."""
        wanted = self._positions(wanted)
        if self._is_compliant:
            _expect(not self.has_measured_torques, f"a file of gravity and load, found measured torques: {_NO_COMMAND}")
            has_backlash = any(joint.backlash != 0.0 for joint in self._joints)
            _expect(not has_backlash, f"a file without backlash, found one with it: {_NO_COMMAND}")
        stiff = wanted - self._deflections(self._torques(wanted, load)) if self._is_compliant else wanted
        return np.array([joint.measured(q) for joint, q in zip(self._joints, stiff.tolist())])

    def torques(self, positions: npt.ArrayLike, load: npt.ArrayLike | None = None) -> _Floats:
        """Torque (N m) of gravity and load about each joint at true ``positions``; of a prismatic one the force (N)."""
        return self._torques(self._positions(positions), load)

    def _torques(self, positions: _Floats, load: npt.ArrayLike | None) -> _Floats:
        rotation, origin = np.eye(3), np.zeros(3)
        axes, origins, carried = [], [], []
        for joint, q in zip(self._joints, positions.tolist()):
            origin = origin + rotation @ joint.link.translation
            rotation = rotation @ joint.link.rotation
            axes.append(rotation @ joint.axis)
            origins.append(origin)
            if joint.turns:
                rotation = rotation @ _rotation_about(joint.axis, q)
            else:
                origin = origin + rotation @ joint.axis * q
            carried.append((joint.link.mass, joint.link.mass * (rotation @ joint.link.center + origin)))
        tip = origin + rotation @ self._tip.translation
        rotation = rotation @ self._tip.rotation
        mass, moment = self._tip.mass, self._tip.mass * (rotation @ self._tip.center + tip)
        wrench = np.zeros(6) if load is None else _vector(load, 6)
        force, about_tip = rotation @ wrench[:3], rotation @ wrench[3:]
        torques = np.zeros(len(self._joints))
        for i in reversed(range(len(self._joints))):
            mass, moment = mass + carried[i][0], moment + carried[i][1]
            if self._joints[i].turns:
                of_gravity = _cross(moment - mass * origins[i], self._gravity)
                torques[i] = axes[i] @ (of_gravity + _cross(tip - origins[i], force) + about_tip)
            else:
                torques[i] = axes[i] @ (mass * self._gravity + force)
        return torques

    def _deflections(self, torques: _Floats) -> _Floats:
        each = zip(self._joints, torques.tolist())
        return np.array([joint.deflection(torque, self._backlash_torque) for joint, torque in each])

    def _positions(self, values: npt.ArrayLike) -> _Floats:
        shape, count = np.shape(values), len(self._joints)
        _expect(shape == (count,), f"positions of one moment, {count} numbers, found an array of shape {shape}")
        positions = _vector(values, count)
        most = _MOST_TURNS * math.tau
        for joint, name, q in zip(self._joints, self.names, positions.tolist()):
            is_plausible = not joint.turns or abs(q) <= most
            _expect(is_plausible, f"at most {most:.3f} rad of joint {name!r} (angles are radians), found {q} rad")
        return positions


def _expect(holds: bool, expected: str) -> None:
    if not holds:
        raise CorrectionError(f"expected {expected}")


def _refuse(constant: str) -> None:
    raise CorrectionError(f"expected a finite number, found {constant}")


def _text(value: object) -> str:
    _expect(isinstance(value, str), f"a text, found {value!r}")
    return str(value)


def _number(value: Any) -> float:
    _expect(isinstance(value, (int, float)) and not isinstance(value, bool), f"a number, found {value!r}")
    number = float(value)
    _expect(math.isfinite(number), f"a finite number, found {value!r}")
    return number


def _vector(values: npt.ArrayLike, length: int) -> _Floats:
    vector = np.asarray(values, dtype=np.float64)
    _expect(vector.shape == (length,), f"{length} numbers, found an array of shape {vector.shape}")
    _expect(bool(np.all(np.isfinite(vector))), f"finite numbers, found {vector}")
    return vector


def _joint(entry: dict[str, Any]) -> _Joint:
    _expect(entry["kind"] in ("revolute", "prismatic"), f"revolute or prismatic, found {entry['kind']!r}")
    axis = _vector(entry["axis"], 3)
    _expect(abs(float(axis @ axis) - 1.0) < 1e-9, f"a unit vector as axis, found {axis}")
    return _Joint(
        turns=entry["kind"] == "revolute",
        gear_ratio=_number(entry["gear_ratio"]),
        harmonics=tuple(_harmonic(harmonic) for harmonic in entry["harmonics"]),
        compliance=_number(entry["compliance_rad_per_nm"]),
        backlash=_number(entry["backlash"]),
        axis=axis,
        link=_link(entry),
    )


def _harmonic(entry: dict[str, Any]) -> tuple[int, float, float]:
    order = _number(entry["order"])
    _expect(order in (1.0, 2.0), f"a harmonic of order 1 or 2, found {order}")
    return int(order), _number(entry["sin"]), _number(entry["cos"])


def _link(entry: dict[str, Any]) -> _Link:
    pose = entry["parent_from_joint"]
    quaternion = _vector(pose["quat_wxyz"], 4)
    _expect(abs(float(quaternion @ quaternion) - 1.0) < 1e-9, f"a unit quaternion, found {quaternion}")
    return _Link(
        translation=_vector(pose["xyz_m"], 3),
        rotation=_rotation(quaternion),
        mass=_number(entry["mass_kg"]),
        center=_vector(entry["center_m"], 3),
    )


def _cross(a: _Floats, b: _Floats) -> _Floats:
    """That of numpy takes ten times as long."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def _rotation(quaternion: _Floats) -> _Floats:
    w, (x, y, z) = float(quaternion[0]), quaternion[1:].tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _rotation_about(axis: _Floats, angle: float) -> _Floats:
    half = 0.5 * angle
    return _rotation(np.concatenate([[math.cos(half)], math.sin(half) * axis]))
