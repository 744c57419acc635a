# OpenImageIO::OpenImageIO from its library and headers alone. Debian 12's own CMake package names the command-line tools
# and OpenCV's headers, neither of which libopenimageio-dev depends on, and fails without them.
find_path(OpenImageIO_INCLUDE_DIR OpenImageIO/imageio.h)
find_library(OpenImageIO_LIBRARY OpenImageIO)
find_library(OpenImageIO_UTIL_LIBRARY OpenImageIO_Util)
find_path(OpenImageIO_IMATH_INCLUDE_DIR Imath/ImathConfig.h)
if(OpenImageIO_INCLUDE_DIR AND EXISTS "${OpenImageIO_INCLUDE_DIR}/OpenImageIO/oiioversion.h")
    file(STRINGS "${OpenImageIO_INCLUDE_DIR}/OpenImageIO/oiioversion.h" parts REGEX "#define OIIO_VERSION_(MAJOR|MINOR|PATCH) +[0-9]+")
    list(TRANSFORM parts REPLACE "^.* ([0-9]+)$" "\\1")
    list(JOIN parts "." OpenImageIO_VERSION)
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenImageIO VERSION_VAR OpenImageIO_VERSION
    REQUIRED_VARS OpenImageIO_LIBRARY OpenImageIO_UTIL_LIBRARY OpenImageIO_INCLUDE_DIR OpenImageIO_IMATH_INCLUDE_DIR)
if(OpenImageIO_FOUND AND NOT TARGET OpenImageIO::OpenImageIO)
    add_library(OpenImageIO::OpenImageIO UNKNOWN IMPORTED)
    set_target_properties(OpenImageIO::OpenImageIO PROPERTIES
        IMPORTED_LOCATION "${OpenImageIO_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${OpenImageIO_INCLUDE_DIR};${OpenImageIO_IMATH_INCLUDE_DIR};${OpenImageIO_IMATH_INCLUDE_DIR}/Imath"
        INTERFACE_LINK_LIBRARIES "${OpenImageIO_UTIL_LIBRARY}")
endif()
mark_as_advanced(OpenImageIO_INCLUDE_DIR OpenImageIO_LIBRARY OpenImageIO_UTIL_LIBRARY OpenImageIO_IMATH_INCLUDE_DIR)
