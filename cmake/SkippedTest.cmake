# SPDX-License-Identifier: Apache-2.0

# swiftgs_add_skipped_test(NAME reason): a test that cannot run here, and is reported as skipped for this reason.
function(swiftgs_add_skipped_test name reason)
  add_test(NAME "${name}" COMMAND ${CMAKE_COMMAND} -E echo "skipped: ${reason}")
  set_tests_properties("${name}" PROPERTIES SKIP_REGULAR_EXPRESSION "^skipped: ")
endfunction()
