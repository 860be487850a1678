"""Adapters of the simulation to the interfaces of other libraries."""
