"""One experiment: the nodes as processes over DDS, recorded, watched, evaluated; and its replay."""
