"""Simulated people who greet."""

from kendon.simulation.person import SimulatedPerson
from kendon.simulation.scripts import SCRIPTS, Act, Script, script

__all__ = ["SCRIPTS", "Act", "Script", "SimulatedPerson", "script"]
