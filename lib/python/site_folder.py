"""Prints the folder of Python packages under an installation prefix, relative to it: site_folder.py PREFIX

In a virtual environment that of its interpreter; else what Debian's looks into, lib/python3.11/dist-packages
under /usr/local, lib/python3/dist-packages under /usr and wherever packages are made.
"""

import os
import sys
import sysconfig

if sys.prefix != sys.base_prefix:
    scheme, root = "venv", sys.prefix
elif "deb_system" not in sysconfig.get_scheme_names():
    scheme, root = sysconfig.get_default_scheme(), sys.prefix
elif os.path.normpath(sys.argv[1]) == "/usr/local":
    scheme, root = "posix_local", "/usr/local"
else:
    scheme, root = "deb_system", "/usr"
print(os.path.relpath(sysconfig.get_path("platlib", scheme), root))
