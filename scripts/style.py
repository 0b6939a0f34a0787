"""What pictures and pages have in common: colours, bands, names."""

MEASURED, ESTIMATE, TRUE, BAND = "#444444", "#0072b2", "#d55e00", "#a6cee3"
BATCH = "#009e73"  # colours that colour-blind eyes tell apart, too
LAW_UNITS = {"torque": "N·m", "speed": "rad/s"}  # of what a learnt law gives
NINETY_PERCENT = 1.645  # half-width of the interval, in standard deviations


def title_of(effect):
    return effect["name"] + (f" ({effect['site']})" if "site" in effect else "")
