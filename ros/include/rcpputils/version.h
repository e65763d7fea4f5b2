#pragma once
#define RCPPUTILS_VERSION_MAJOR 2
#define RCPPUTILS_VERSION_MINOR 11
#define RCPPUTILS_VERSION_PATCH 0
#define RCPPUTILS_VERSION_STR "2.11.0"
#define RCPPUTILS_VERSION_GTE(major, minor, patch) \
  (RCPPUTILS_VERSION_MAJOR > (major) ||            \
   (RCPPUTILS_VERSION_MAJOR == (major) &&          \
    (RCPPUTILS_VERSION_MINOR > (minor) ||          \
     (RCPPUTILS_VERSION_MINOR == (minor) && RCPPUTILS_VERSION_PATCH >= (patch)))))
