"""Simulated people who greet."""

from kendon.simulation.body import Body, draw_body
from kendon.simulation.motion import Motion, move
from kendon.simulation.movements import MOVEMENTS, Movement, draw_movement
from kendon.simulation.movers import Performance, draw_mover, perform_movement
from kendon.simulation.person import SimulatedPerson
from kendon.simulation.scripts import SCRIPTS, Act, Script, script
from kendon.simulation.sensors import SENSORS, Sensor, sensor
from kendon.simulation.sets import Seeing, Signs, simulate

__all__ = [
    "MOVEMENTS",
    "SCRIPTS",
    "SENSORS",
    "Act",
    "Body",
    "Motion",
    "Movement",
    "Performance",
    "Script",
    "Seeing",
    "Sensor",
    "Signs",
    "SimulatedPerson",
    "draw_body",
    "draw_movement",
    "draw_mover",
    "move",
    "perform_movement",
    "script",
    "sensor",
    "simulate",
]
