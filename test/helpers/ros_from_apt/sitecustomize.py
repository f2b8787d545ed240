"""Python without the packages that apt has not."""

import sys

sys.modules.update(dict.fromkeys(('mcap', 'rosbags', 'starlette')))
