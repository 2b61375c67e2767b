"""Make the Bokeh charts of the live page, which streams into them, and of the run report, which fills them."""
