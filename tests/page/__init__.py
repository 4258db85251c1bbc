"""Tests of the operator's page in a headless Chromium, on a live node with the sample scene.

`stage` has the master, the scene's nodes and `camera_stream`, `browser` the page as an operator sees it. Everything an operator
can press is pressed, and what it does is seen on topics, in TF and in the projector's file.

    PYTHONPATH=tests python3 -m unittest discover -s tests/page -t tests     after ./test build

Screenshots go to test_output/operator_page, with RCS_WRITE_DOCS=1 to docs/images, where the how-to page shows them.
"""
