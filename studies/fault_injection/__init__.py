"""Bad inputs, kills and full disks by the thousand: what comes of them is counted."""
