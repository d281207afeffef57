"""Simulated people who greet."""

from kendon.simulation.person import SimulatedPerson
from kendon.simulation.scripts import SCRIPTS, Act, Script, script
from kendon.simulation.sensors import SENSORS, Sensor, sensor
from kendon.simulation.sets import Seeing, simulate

__all__ = [
    "SCRIPTS",
    "SENSORS",
    "Act",
    "Script",
    "Seeing",
    "Sensor",
    "SimulatedPerson",
    "script",
    "sensor",
    "simulate",
]
