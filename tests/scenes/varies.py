"""Why rviz draws some scenes differently from run to run: what it does in the order of addresses."""

SAME_DEPTH = "things at the same depth: rviz draws them in the order of their addresses"
SAME_DISTANCE = "translucent things at the same distance: rviz draws them in the order of their addresses"
GROUPS = (
    "rviz applies the visibility of a group's children only if the group lies before the CameraPub in memory; this picture"
    " is of a run where it did"
)
