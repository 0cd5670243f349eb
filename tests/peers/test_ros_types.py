"""What `ros_types` makes of the definitions in msgs/."""

import unittest

import ros_types


def every_definition(kind: str) -> list[str]:
    """The full names of all definitions of a kind under msgs/."""
    own = [f"planesman_msgs/{kind}/{path.stem}" for path in ros_types.MSGS.glob(f"{kind}/*.{kind}")]
    standard = ros_types.MSGS.glob(f"standard/**/{kind}/*.{kind}")
    return own + [f"{path.parent.parent.name}/{kind}/{path.stem}" for path in standard]


class Definitions(unittest.TestCase):
    def test_every_message_survives_its_own_encoding(self):
        for name in every_definition("msg"):
            with self.subTest(name):
                zero = ros_types.from_json(name, {})
                again = ros_types.message(name).deserialize(zero.serialize(use_version_2=False))
                self.assertEqual(ros_types.to_json(name, again), ros_types.to_json(name, zero))

    def test_every_service_has_a_request_and_a_response(self):
        for name in every_definition("srv"):
            for part in ("Request", "Response"):
                with self.subTest(name, part=part):
                    self.assertIn("rmw_sequence", ros_types.service_part(name, part).__annotations__)

    def test_every_action_has_its_derived_parts(self):
        for name in every_definition("action"):
            for part in ("SendGoal", "GetResult"):
                with self.subTest(name, part=part):
                    self.assertIn("goal_id", ros_types.service_part(f"{name}_{part}", "Request").__annotations__)
            feedback = ros_types.to_json(f"{name}_FeedbackMessage", ros_types.from_json(f"{name}_FeedbackMessage", {}))
            self.assertEqual(list(feedback), ["goal_id", "feedback"])

    def test_types_have_the_names_that_ros_gives_them_in_dds(self):
        self.assertEqual(ros_types.dds_type_name("std_msgs/msg/Float64"), "std_msgs::msg::dds_::Float64_")
        self.assertEqual(ros_types.ros_type_name("std_msgs::msg::dds_::Float64_"), "std_msgs/msg/Float64")


class Parsing(unittest.TestCase):
    def test_fields_constants_and_bounds_are_told_apart(self):
        fields, constants = ros_types.parse(
            """
            uint8 HELD = 1      # a constant
            string WHO="planes"
            float64[36] covariance
            string<=8[<=5] names
            Header[] headers
            std_msgs/Header header
            float64 gain 0.5
            """,
            "std_msgs",
        )
        self.assertEqual(constants, {"HELD": 1, "WHO": "planes"})
        self.assertEqual(
            [(field.name, field.base, field.shape, field.length, field.default) for field in fields],
            [
                ("covariance", "float64", "array", 36, None),
                ("names", "string", "sequence", 5, None),
                ("headers", "std_msgs/msg/Header", "sequence", None, None),
                ("header", "std_msgs/msg/Header", "one", None, None),
                ("gain", "float64", "one", None, "0.5"),
            ],
        )

    def test_what_is_no_field_is_refused(self):
        with self.assertRaisesRegex(ValueError, "neither a field nor a constant: float64"):
            ros_types.parse("float64", "std_msgs")

    def test_an_unknown_field_is_refused(self):
        with self.assertRaisesRegex(ValueError, "no field depht"):
            ros_types.from_json("planesman_msgs/msg/VehicleState", {"depht": 1.0})


class Encoding(unittest.TestCase):
    def test_a_float64_is_plain_little_endian_cdr(self):
        half = ros_types.from_json("std_msgs/msg/Float64", {"data": 0.5})
        self.assertEqual(half.serialize(use_version_2=False), bytes.fromhex("00010000" "000000000000e03f"))


if __name__ == "__main__":
    unittest.main()
