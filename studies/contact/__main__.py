"""`python -m studies.contact`: the contact estimator, studied."""

import sys

from studies.common.command import run
from studies.contact.contact_study import contact

if __name__ == "__main__":
    sys.exit(run(contact, "contact"))
