"""What `armukf estimate --watch --events` writes: a line as soon as something is sure, one more when it has settled."""

import json


def events_in(text):
    """An event each, as it was last told; `t` stays when it was told first."""
    events = []
    for line in text.splitlines():
        event = json.loads(line)
        if event["settled"] and events:
            events[-1] = {**event, "t": events[-1]["t"]}
        else:
            events.append(event)
    return events
