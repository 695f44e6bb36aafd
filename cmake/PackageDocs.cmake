# SPDX-License-Identifier: Apache-2.0

# Run by cpack before it builds packages: puts the licence of each, those of what is compiled or linked into it, and the
# changelog where Debian has them.
execute_process(COMMAND python3 -B "${CPACK_SWIFTGS_SOURCE}/cmake/licences.py" "${CPACK_SWIFTGS_BUILD}"
  OUTPUT_VARIABLE licences COMMAND_ERROR_IS_FATAL ANY)
set(copyright [[
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: SwiftGS

Files: *
Copyright: 2026 the contributors of SwiftGS
License: Apache-2.0
 The full text of the licence is in /usr/share/common-licenses/Apache-2.0.
]])
file(READ "${CPACK_SWIFTGS_SOURCE}/CHANGELOG.md" changes)
string(REGEX MATCH "\n## .[0-9.]+. - ([0-9-]+)\n" date "${changes}")
execute_process(COMMAND date -u -R -d "${CMAKE_MATCH_1}" OUTPUT_VARIABLE date COMMAND_ERROR_IS_FATAL ANY)
set(changes "${CPACK_TEMPORARY_DIRECTORY}/changelog.Debian")
file(WRITE "${changes}" "swiftgs (${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium

  * New version; changelog.gz says what is new.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}")
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} upper)
  set(folder "${CPACK_TEMPORARY_DIRECTORY}/${component}/usr/share/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME}")
  file(WRITE "${folder}/copyright" "${copyright}")
  file(WRITE "${folder}/third-party-licences.txt" "${licences}")
  execute_process(COMMAND gzip -9n INPUT_FILE "${CPACK_SWIFTGS_SOURCE}/CHANGELOG.md"
    OUTPUT_FILE "${folder}/changelog.gz" COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND gzip -9n INPUT_FILE "${changes}"
    OUTPUT_FILE "${folder}/changelog.Debian.gz" COMMAND_ERROR_IS_FATAL ANY)
endforeach()
