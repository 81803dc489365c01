# Read by ctest: a test for each suite of a program, PREFIX/SUITE, since a process costs more than most tests take. One
# test alone: PROGRAM --gtest_filter=SUITE.TEST. Given: program, prefix, left_out (a pattern of GoogleTest), limit (s).
if(NOT EXISTS ${program})
  add_test(${prefix}_NOT_BUILT ${program}_NOT_BUILT)
  return()
endif()
execute_process(COMMAND ${program} --gtest_list_tests --gtest_filter=*-${left_out} OUTPUT_VARIABLE listed RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${program} --gtest_list_tests ended with ${status}.")
endif()
string(REGEX MATCHALL "(^|\n)[^ \n]+\\.( +#[^\n]*)?(\n|$)" suites "${listed}")  # "Suite.", "Kind/0.  # TypeParam = ..."
foreach(suite ${suites})
  string(REGEX REPLACE "[\n]|\\.( +#.*)?[\n]?$" "" suite "${suite}")
  add_test(${prefix}/${suite} ${program} --gtest_filter=${suite}.*-${left_out})
  set_tests_properties(${prefix}/${suite} PROPERTIES TIMEOUT ${limit} LABELS ${prefix})
endforeach()
