"""Serve the live page, and write the HTML reports and the pictures of runs.

Public modules; everything else is for this package alone (an import contract checks it):

* ``passafe_dashboard.process``: the dashboard as a process of the system;
* ``passafe_dashboard.browsing``: the pages of logs and experiments alone;
* ``passafe_dashboard.address``: the check that the page's address is free;
* ``passafe_dashboard.run_report``: HTML report of a log, or of several over one another;
* ``passafe_dashboard.comparison_picture``: picture of runs over one another;
* ``passafe_dashboard.experiment_report``: HTML report and picture of an experiment;
* ``passafe_dashboard.feasibility_picture``: picture of a feasibility atlas;
* ``passafe_dashboard.errors``: what these refuse.
"""
