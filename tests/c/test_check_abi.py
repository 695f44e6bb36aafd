# SPDX-License-Identifier: Apache-2.0
"""The check of the binary interface notices what breaks programs, and says what to do about it."""
import unittest

import check_abi

HEADER = """
/* swiftgs_unreal(void); */
#define SWIFTGS_C_API
typedef int32_t (*swiftgs_callback)(void* context,
                                    double part);
enum { SWIFTGS_A = 0, SWIFTGS_B = 7 };  // SWIFTGS_UNREAL = 1
typedef struct swiftgs_one {
  uint32_t size;          ///< units, such as bytes; and more
  int32_t width, height;
  double rotation[9];
  const char* name;
} swiftgs_one;
typedef struct swiftgs_handle swiftgs_handle;
SWIFTGS_C_API swiftgs_status swiftgs_do(const swiftgs_one* one,
                                        double scale);
"""
RECORD = ["abi 1.4", "function int swiftgs_do(int a)", "value SWIFTGS_A = 0", "struct swiftgs_one: 8 bytes",
          "member swiftgs_one.size: uint32_t, byte 0, 4 bytes", "member swiftgs_one.a: int32_t, byte 4, 4 bytes"]
GROWN = [*RECORD[:3], "struct swiftgs_one: 16 bytes", *RECORD[4:],
         "member swiftgs_one.b: uint64_t, byte 8, 8 bytes"]


def numbered(lines, version):
    return [f"abi {version}", *lines[1:]]


class Declarations(unittest.TestCase):
    def test_all_are_found_and_comments_are_not(self):
        structs, enumerators, functions, callbacks = check_abi.declared(check_abi.without_comments(HEADER))
        self.assertEqual(structs, {"swiftgs_one": [("uint32_t", "size"), ("int32_t", "width"), ("int32_t", "height"),
                                                   ("double[9]", "rotation"), ("const char*", "name")]})
        self.assertEqual(enumerators, ["SWIFTGS_A", "SWIFTGS_B"])
        self.assertEqual(functions, ["swiftgs_status swiftgs_do(const swiftgs_one*, double)"])
        self.assertEqual(callbacks, ["int32_t (*swiftgs_callback)(void*, double)"])
        self.assertEqual(check_abi.name_of(functions[0]), "swiftgs_do")


class Comparison(unittest.TestCase):
    def check(self, found, fits, part):
        differs, fitted = check_abi.compare(RECORD, found)
        self.assertEqual(fitted, fits)
        self.assertIn(part, "\n".join(differs))

    def test_the_same_is_silent(self):
        self.assertEqual(check_abi.compare(RECORD, RECORD), ([], True))

    def test_what_is_gone_or_moved_needs_the_first_number(self):
        for line in range(1, len(RECORD)):
            self.check([*RECORD[:line], *RECORD[line + 1:]], False, "raise SWIFTGS_ABI_MAJOR")
        moved = [line.replace("byte 4", "byte 8") for line in RECORD]
        self.check(moved, False, "- member swiftgs_one.a: int32_t, byte 4")
        self.check(numbered(moved, "1.5"), False, "raise SWIFTGS_ABI_MAJOR")
        self.check(numbered(moved, "2.0"), True, "swiftgs_record_abi")

    def test_an_addition_needs_the_second_number(self):
        self.check([*RECORD, "function int swiftgs_more(void)"], False, "raise SWIFTGS_ABI_MINOR")
        self.check(GROWN, False, "raise SWIFTGS_ABI_MINOR")
        self.check(numbered(GROWN, "1.5"), True, "swiftgs_record_abi")

    def test_a_reserved_member_may_be_named_where_it_is(self):
        before = [line.replace("swiftgs_one.a: int32_t", "swiftgs_one.reserved: uint32_t") for line in RECORD]
        self.assertEqual(check_abi.compare(before, numbered(RECORD, "1.5"))[1], True)
        self.assertEqual(check_abi.compare(before, RECORD)[1], False)
        moved = [line.replace("byte 4", "byte 8") for line in RECORD]
        self.assertEqual(check_abi.compare(before, numbered(moved, "1.5"))[1], False)
        self.assertEqual(check_abi.compare(before, numbered(before[:-1], "1.5"))[1], False)

    def test_a_struct_that_shrinks_breaks(self):
        self.check(numbered([line.replace("8 bytes", "4 bytes") for line in RECORD[:-1]], "1.5"), False, "MAJOR")


class Padding(unittest.TestCase):
    def test_gaps_are_named(self):
        self.assertEqual(check_abi.padding(RECORD), [])
        self.assertEqual(check_abi.padding(GROWN), [])
        gap = [*RECORD[:3], "struct swiftgs_one: 16 bytes", RECORD[4], "member swiftgs_one.b: double, byte 8, 8 bytes"]
        self.assertIn("swiftgs_one.b: padding before it", "\n".join(check_abi.padding(gap)))
        behind = [line.replace("swiftgs_one: 8", "swiftgs_one: 12") for line in RECORD]
        self.assertIn("struct swiftgs_one: padding at byte 8", "\n".join(check_abi.padding(behind)))


if __name__ == "__main__":
    unittest.main()
