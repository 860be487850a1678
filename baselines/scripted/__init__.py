"""The scripted baseline: the paper's controller in two phases, made strong.

``ScriptedPolicy`` keeps the phase of every world. At each tick it updates the ``VesselObserver``,
which estimates the vessel's motion and the drift of its water, and then lets the phase act:

- APPROACH (``GraspController``): each boat follows its ``ApproachPath``, a circle round the hull
  and a spiral, to the waypoint above its slot; the team then descends together (``Docking``).
- PUSH (``PushController``), from closure on: ``PathPlanner`` plans a path of arcs to the goal and
  a timetable, ``PathFollower`` finds the force and moment that keep the vessel on it
  (``PreviewLqr``), ``allocate`` divides them among the boats. A lost grasp leads back to APPROACH.
"""

from baselines.scripted.gains import GraspGains, PathGains, PushGains, Tolerances
from baselines.scripted.planner import PathPlanner
from baselines.scripted.scripted_policy import ScriptedPolicy

__all__ = ["GraspGains", "PathGains", "PathPlanner", "PushGains", "ScriptedPolicy", "Tolerances"]
