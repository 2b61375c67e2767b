"""Bring messages of the bus to the browsers that show the live page.

A message goes one way: ``bus_reader`` decodes what arrived and pushes it into the ``feed``; ``broadcast``, at the
frame rate, lets ``page_state`` and ``frames`` turn the feed into JSON for each client, and
``passafe_dashboard.routes.state`` sends it. Imports follow that order, which an import contract checks: the feed
knows neither reader nor clients.
"""
