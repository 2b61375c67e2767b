"""The live page, the HTML report and the figures that they share."""
