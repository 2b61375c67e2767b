"""Charts as SVG without a browser: walks a Bokeh figure and writes what it says.

There is one definition of each chart, for page, report and pictures. Bokeh itself exports pictures only through
a browser; matplotlib would need every chart to be defined a second time. SVG is text, so a picture of the same
log is the same to the last byte. Parts of a figure that are not known here raise ``UndrawableError``.
"""
