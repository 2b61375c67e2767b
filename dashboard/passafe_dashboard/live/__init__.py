"""Bring messages of the bus to the browsers that show the live page.

A message goes one way, and no module imports one that comes after it (an import contract checks it):
``bus_reader`` decodes what arrived and pushes it into the ``feed``; ``page_state`` and ``frames`` turn the feed into
JSON; ``broadcast`` does both at the frame rate; ``passafe_dashboard.routes.state`` sends the frames.
"""
