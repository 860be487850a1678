"""What numbers of parameters may be: ranges far wider than any use, within which all stays finite.

Their ends keep what is computed from them, for the largest team and the longest vessel too, far
from the ends of floating-point numbers, and a step from taking minutes.
"""

import math
from typing import Annotated

from asv_env.checks import TINY, Number, Pair, Truth, Whole, interval

FOREVER = 1e9  #: longest time, s
FAR = 1e6  #: longest distance, m
MASS = Number(1e-6, 1e12)  #: of a hull, kg

BoatLength = Annotated[float, Number(1e-4, 1e2)]
VesselLength = Annotated[float, Number(1e-3, 1e4)]
Distance = Annotated[float, Number(TINY, FAR)]
DistanceOrZero = Annotated[float, Number(0.0, FAR)]
Distances = Annotated[tuple[float, float], interval(0.0, FAR)]
Spacing = Annotated[float, Number(1.0, 1e6)]
Mass = Annotated[float, MASS]
AddedMasses = Annotated[tuple[float, float], Pair("(surge, sway) added mass", 0.0, 1e12)]
Inertia = Annotated[float, Number(1e-15, 1e24)]
AddedInertia = Annotated[float, Number(0.0, 1e24)]
DragPair = Annotated[tuple[float, float], Pair("(linear, quadratic) drag", 0.0, 1e24)]
Drag = Annotated[float, Number(0.0, 1e12)]
Thrust = Annotated[float, Number(TINY, 1e9)]
Lag = Annotated[float, Number(1e-6, 1e3)]
Lags = Annotated[tuple[float, float], interval(1e-6, 1e3)]
Loads = Annotated[tuple[float, float], interval(0.05, 100.0)]
Friction = Annotated[float, Number(0.0, 1e2)]
Frictions = Annotated[tuple[float, float], interval(TINY, 1e2)]
Fraction = Annotated[float, Number(0.0, 1.0)]
Spread = Annotated[float, Number(0.0, 0.95)]
SizeSpread = Annotated[float, Number(0.0, 0.5)]
Bias = Annotated[float, Number(-0.95, 0.95)]
Angle = Annotated[float, Number(-1e6, 1e6)]
AngleLimit = Annotated[float, Number(0.0, math.pi)]
AngleTolerance = Annotated[float, Number(TINY, math.pi)]
Tolerance = Annotated[float, Number(TINY, 1e6)]
ToleranceOrZero = Annotated[float, Number(0.0, 1e6)]
Speed = Annotated[float, Number(0.0, 1e3)]
Noise = Annotated[float, Number(0.0, 1e3)]
Acceleration = Annotated[float, Number(1e-6, 1e6)]
FullMotion = Annotated[float, Number(TINY, 1e3)]
Responses = Annotated[tuple[float, float], Pair("(surge, yaw) time constants", 0.0, 1e3)]
Accelerations = Annotated[tuple[float, float], Pair("(surge, yaw) accelerations", 1e-6, 1e6)]
Share = Annotated[float, Number(0.0, 0.95)]
Duration = Annotated[float, Number(TINY, FOREVER)]
DurationOrZero = Annotated[float, Number(0.0, FOREVER)]
Durations = Annotated[tuple[float, float], interval(0.0, FOREVER)]
Rate = Annotated[int, Whole(1, 10_000)]
Count = Annotated[int, Whole(0, 100)]
Switch = Annotated[bool, Truth()]
Weight = Annotated[float, Number(0.0, 1e9)]
