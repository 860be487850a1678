"""Pictures and films of the worlds."""

MODES = ("human", "rgb_array")  #: render modes of the viewer and of all adapters
