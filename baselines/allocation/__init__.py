"""The baseline by force allocation: boats on all sides of the hull drive, brake and turn it.

``AllocationPolicy`` keeps the phase of every world. At each tick the ``VesselObserver`` estimates
the vessel's motion, and then

- each boat goes to its contact point of the team's ``Formation`` (``ContactPoints``) by the
  shortest path round the hull (``Detours``), and docks there (``ContactApproach``);
- once the wrench cone of the boats in place contains what a direct path takes, ``DirectPath``
  turns the vessel towards its goal, drives it there, and turns it to the goal's heading;
- the wrench that this takes is shared out over the boats in place (``share``), which exert it by
  the speed and the heading at which they go with the hull (``Contact``).

Among obstacles boats take clear routes, and the vessel goes from waypoint to waypoint
(``Waypoints``), straight between places where it can turn. Where there is no such path the team is
that of the script.

Two boats cannot do all that from one formation. They do one thing at a time, from a pair of contact
points for each (``Manoeuvres``), and let the vessel coast in between (``Pushes``).
"""

from baselines.allocation.allocation_policy import AllocationPolicy

__all__ = ["AllocationPolicy"]
