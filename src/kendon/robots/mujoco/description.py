"""What a robot's mapping file says: which joints of an MJCF or URDF are base, head, eyes and arms.

A mapping is a TOML file beside the model (`robots/models/vizzy.toml` is one with everything).
Angles are in degrees (metres for joints that slide), joint speeds in rad/s (or m/s), times in s.
This module checks the file for itself; `kendon.robots.mujoco.body` holds it against the model.
"""

from __future__ import annotations

import functools
import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from kendon.errors import DataError, ParameterError, UnknownNameError
from kendon.robots.drive import BaseLimits

#: The keys of a mapping file, all of them and those it cannot do without.
_KEYS = (
    "title", "model", "base", "head", "eyes", "hand", "speeds", "rest", "gestures", "expressions",
)  # fmt: skip
_REQUIRED = ("title", "model", "base", "head", "gestures")
#: What every robot must be able to do, since the greeting tree asks for it.
_EVERY_GESTURE = ("home", "wave", "handshake")
_LIMITS = tuple(field.name for field in fields(BaseLimits))


@dataclass(frozen=True, slots=True)
class Wheels:
    """The joints of two driven wheels; they only turn as the road passes below them."""

    left: str
    right: str
    radius: float  # [m]
    track: float  # [m], from wheel to wheel


@dataclass(frozen=True, slots=True)
class HeadJoints:
    """The joints that turn the head, and the site or body whose x axis runs out of the face."""

    pan: str
    tilt: str
    face: str
    tilt_range: tuple[float, float] | None  # [degrees up], narrower than the joint's
    rate: float  # [rad/s]
    acceleration: float  # [rad/s^2]


@dataclass(frozen=True, slots=True)
class Eye:
    """A joint that turns an eye, and the site or body whose x axis runs out of its pupil."""

    joint: str
    site: str


@dataclass(frozen=True, slots=True)
class Keyframe:
    """Where some joints are at one instant of a gesture."""

    t: float  # [s] since its start
    joints: Mapping[str, float]  # name -> angle [degrees] or way [m]
    hold: bool = False  # whether all other joints that the gesture has moved stay
    rest: bool = False  # whether they come to rest


@dataclass(frozen=True)
class RobotDescription:
    """A whole mapping file, checked for itself but not yet against the model."""

    file: Path | Traversable  # where it stands
    title: str
    model: Path | Traversable  # the MJCF or URDF file
    base: str  # the body that drives
    wheels: Wheels | None
    limits: BaseLimits
    head: HeadJoints
    eyes: tuple[Eye, ...]
    hand: str | None  # the site or body that is shaken: in pictures the person's hand meets it
    speeds: Mapping[str, float]  # joint name or pattern such as "l_*" -> most [rad/s, m/s]
    rest: Mapping[str, float]  # name -> angle [degrees] or way [m]; 0 for all others
    gestures: Mapping[str, tuple[Keyframe, ...]]
    expressions: Mapping[str, Mapping[str, float]]  # name -> joints in full intensity

    def error(self, message: str) -> DataError:
        """The error that something in this file is wrong."""
        return DataError(message, file=str(self.file))


@functools.cache
def vizzy() -> RobotDescription:
    """The description of kendon's own Vizzy; it cannot be changed, so that all may share it."""
    return read_description(resources.files("kendon.robots") / "models" / "vizzy.toml")


def read_description(file: str | Path | Traversable) -> RobotDescription:
    """Read a mapping file.

    Raises:
        DataError: it cannot be read, or something in it is missing, unknown or out of range.
    """
    place = Path(file) if isinstance(file, str) else file
    try:
        content = tomllib.loads(place.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise DataError("there is no such robot file", file=str(place)) from None
    except OSError as error:
        raise DataError(f"cannot be read ({error.strerror})", file=str(place)) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise DataError(f"this is not a readable robot file ({error})", file=str(place)) from None
    return _Reader(place, content).description()


class _Reader:
    """Takes values out of a mapping file by kind; every error names the file and the key."""

    def __init__(self, file: Path | Traversable, content: dict[str, Any]) -> None:
        self.file = file
        self.content = content

    def fail(self, message: str) -> DataError:
        return DataError(message, file=str(self.file))

    def description(self) -> RobotDescription:
        top = self.table("the file", self.content, _KEYS, _REQUIRED)
        base = self.table("base", top["base"], ("body", "wheels", *_LIMITS), ("body",))
        head = self.table(
            "head", top["head"],
            ("pan", "tilt", "face", "tilt_range", "rate", "acceleration"), ("pan", "tilt", "face"),
        )  # fmt: skip
        model = self.text("model", top["model"])
        folder = self.file.parent if isinstance(self.file, Path) else _models()
        gestures = {
            name: self.keyframes(f"gestures.{name}", frames)
            for name, frames in self.mapping("gestures", top["gestures"]).items()
        }
        for name in _EVERY_GESTURE:
            if name not in gestures:
                raise self.fail(
                    f"gestures lacks {name!r}; every robot has {', '.join(_EVERY_GESTURE)}"
                )
        expressions = {
            name: self.numbers(f"expressions.{name}", joints)
            for name, joints in self.mapping("expressions", top.get("expressions", {})).items()
        }
        return RobotDescription(
            file=self.file,
            title=self.text("title", top["title"]),
            model=folder / model,
            base=self.text("base.body", base["body"]),
            wheels=self.wheels(base["wheels"]) if "wheels" in base else None,
            limits=self.limits({k: base[k] for k in _LIMITS if k in base}),
            head=self.head(head),
            eyes=tuple(self.eye(f"eyes[{i}]", eye) for i, eye in enumerate(top.get("eyes", []))),
            hand=self.text("hand", top["hand"]) if "hand" in top else None,
            speeds=self.numbers("speeds", top.get("speeds", {}), positive=True),
            rest=self.numbers("rest", top.get("rest", {})),
            gestures=gestures,
            expressions={"neutral": {}, **expressions},
        )

    def table(
        self, key: str, value: Any, valid: Iterable[str], required: Iterable[str]
    ) -> dict[str, Any]:
        content = self.mapping(key, value)
        valid = tuple(valid)
        for name in content:
            if name not in valid:
                raise self.fail(f"{key}: {UnknownNameError('key', name, valid)}")
        for name in required:
            if name not in content:
                raise self.fail(f"{key} lacks {name!r}; it has {', '.join(valid)}")
        return content

    def mapping(self, key: str, value: Any) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise self.fail(f"{key} is a table of names and values, not {value!r}")
        return value

    def text(self, key: str, value: Any) -> str:
        if not isinstance(value, str) or not value.strip():
            raise self.fail(f"{key} is a text, not {value!r}")
        return value

    def number(self, key: str, value: Any, *, positive: bool = False) -> float:
        fine = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not fine or not math.isfinite(value) or (positive and value <= 0):
            wanted = "a number above 0" if positive else "a finite number"
            raise self.fail(f"{key} is {wanted}, not {value!r}")
        return float(value)

    def flag(self, key: str, content: dict[str, Any], name: str) -> bool:
        value = content.pop(name, False)
        if not isinstance(value, bool):
            raise self.fail(f"{key}.{name} is true or false, not {value!r}")
        return value

    def numbers(self, key: str, value: Any, *, positive: bool = False) -> dict[str, float]:
        return {
            name: self.number(f"{key}.{name}", number, positive=positive)
            for name, number in self.mapping(key, value).items()
        }

    def wheels(self, value: Any) -> Wheels:
        names = ("left", "right", "radius", "track")
        content = self.table("base.wheels", value, names, names)
        return Wheels(
            self.text("base.wheels.left", content["left"]),
            self.text("base.wheels.right", content["right"]),
            self.number("base.wheels.radius", content["radius"], positive=True),
            self.number("base.wheels.track", content["track"], positive=True),
        )

    def limits(self, content: dict[str, Any]) -> BaseLimits:
        try:
            return BaseLimits(**{k: self.number(f"base.{k}", v) for k, v in content.items()})
        except ParameterError as error:
            raise self.fail(str(error)) from None

    def head(self, content: dict[str, Any]) -> HeadJoints:
        tilt_range = None
        if "tilt_range" in content:
            ends = content["tilt_range"]
            if not isinstance(ends, list) or len(ends) != 2:
                raise self.fail(f"head.tilt_range is [lowest, highest] in degrees, not {ends!r}")
            low, high = (self.number("head.tilt_range", end) for end in ends)
            tilt_range = (low, high)
        return HeadJoints(
            self.text("head.pan", content["pan"]),
            self.text("head.tilt", content["tilt"]),
            self.text("head.face", content["face"]),
            tilt_range,
            self.number("head.rate", content.get("rate", 2.0), positive=True),
            self.number("head.acceleration", content.get("acceleration", 10.0), positive=True),
        )

    def eye(self, key: str, value: Any) -> Eye:
        content = self.table(key, value, ("joint", "site"), ("joint", "site"))
        return Eye(
            self.text(f"{key}.joint", content["joint"]), self.text(f"{key}.site", content["site"])
        )

    def keyframes(self, key: str, value: Any) -> tuple[Keyframe, ...]:
        if not isinstance(value, list) or not value:
            raise self.fail(f"{key} is a list of keyframes, written [[{key}]], not {value!r}")
        frames: list[Keyframe] = []
        for i, frame in enumerate(value):
            content = dict(self.mapping(f"{key}[{i}]", frame))
            hold, rest = (self.flag(f"{key}[{i}]", content, name) for name in ("hold", "rest"))
            joints = self.numbers(f"{key}[{i}]", content)
            t = joints.pop("t", math.nan)
            if not t > (frames[-1].t if frames else 0.0):
                raise self.fail(
                    f"{key}[{i}] needs a time t [s] after {frames[-1].t if frames else 0:g},"
                    f" not {content.get('t')!r}"
                )
            frames.append(Keyframe(t, joints, hold, rest))
        return tuple(frames)


def _models() -> Traversable:
    return resources.files("kendon.robots") / "models"
