"""Charts made in Python, once: the live page streams into them, report and pictures fill them."""
