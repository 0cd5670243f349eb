//! The standard types have the hashes that ROS 2 Jazzy gives them, so their definitions are the same.
//!
//! Sources: for messages the Jazzy type store of the Python package `rosbags` 0.11.9; for services, and for
//! `ServiceEventInfo` (whose `char` array that package hashes as `char` where rosidl has `uint8`), the C code
//! that rosidl itself has generated for them, as published with ROS distributions. No such code was found for
//! `rcl_interfaces/srv/GetLoggerLevels`, which is therefore not here.

use planesman_msgs::{Message, Service, registry, type_info};

const MESSAGES: &[(&str, &str)] = &[
    (
        "action_msgs/msg/GoalInfo",
        "6398fe763154554353930716b225947f93b672f0fb2e49fdd01bb7a7e37933e9",
    ),
    (
        "action_msgs/msg/GoalStatus",
        "32f4cfd717735d17657e1178f24431c1ce996c878c515230f6c5b3476819dbb9",
    ),
    (
        "action_msgs/msg/GoalStatusArray",
        "6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e",
    ),
    (
        "builtin_interfaces/msg/Duration",
        "e8d009f659816f758b75334ee1a9ca5b5c0b859843261f14c7f937349599d93b",
    ),
    (
        "builtin_interfaces/msg/Time",
        "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197",
    ),
    (
        "diagnostic_msgs/msg/DiagnosticArray",
        "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e",
    ),
    (
        "diagnostic_msgs/msg/DiagnosticStatus",
        "b0e3e692ea2d54a8af2f4ef1930e81556a2db55216b771f8a7d2724ed47bf0e4",
    ),
    (
        "diagnostic_msgs/msg/KeyValue",
        "d68081eaa540288c5440753baecef0c4e16e81a5f78ad68902ded5100413bb42",
    ),
    (
        "geometry_msgs/msg/Point",
        "6963084842a9b04494d6b2941d11444708d892da2f4b09843b9c43f42a7f6881",
    ),
    (
        "geometry_msgs/msg/Pose",
        "d501954e9476cea2996984e812054b68026ae0bfae789d9a10b23daf35cc90fa",
    ),
    (
        "geometry_msgs/msg/PoseWithCovariance",
        "9a7c0fd234b7f45c6098745ecccd773ca1085670e64107135397aee31c02e1bb",
    ),
    (
        "geometry_msgs/msg/Quaternion",
        "8a765f66778c8ff7c8ab94afcc590a2ed5325a1d9a076ffff38fbce36f458684",
    ),
    (
        "geometry_msgs/msg/Transform",
        "beb83fbe698636351461f6f35d1abb20010c43d55374d81bd041f1ba2581fddc",
    ),
    (
        "geometry_msgs/msg/TransformStamped",
        "0a241f87d04668d94099cbb5ba11691d5ad32c2f29682e4eb5653424bd275206",
    ),
    (
        "geometry_msgs/msg/Twist",
        "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    ),
    (
        "geometry_msgs/msg/TwistWithCovariance",
        "49f574f033f095d8b6cd1beaca5ca7925e296e84af1716d16c89d38b059c8c18",
    ),
    (
        "geometry_msgs/msg/Vector3",
        "cc12fe83e4c02719f1ce8070bfd14aecd40f75a96696a67a2a1f37f7dbb0765d",
    ),
    (
        "nav_msgs/msg/Odometry",
        "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    ),
    (
        "rcl_interfaces/msg/FloatingPointRange",
        "e6af23a23c177fee5f3075c8b1e435162a9b63c863d78c06017460b49684262d",
    ),
    (
        "rcl_interfaces/msg/IntegerRange",
        "f7b7fdc0f65f07702e099218e13288c3963bcb9345bde78b560e6cd19800fc5a",
    ),
    (
        "rcl_interfaces/msg/ListParametersResult",
        "237ae3428413dcbcfb452b510c42355f3a2b021dc091afa3e18526d57022f1cd",
    ),
    (
        "rcl_interfaces/msg/Log",
        "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac",
    ),
    (
        "rcl_interfaces/msg/LoggerLevel",
        "95785cc42f048ab4f395af65035aeaf2181d8e1c7a44edb8ad4558445fdb43c0",
    ),
    (
        "rcl_interfaces/msg/Parameter",
        "ddfe6442cffc462317adb5c92536a7b6dd55858c5c3e1e328165a6b73c2831af",
    ),
    (
        "rcl_interfaces/msg/ParameterDescriptor",
        "52175dbfda6c51153101d33d2a9da05743f66f02d5ab2ca9ec4709b46b73d704",
    ),
    (
        "rcl_interfaces/msg/ParameterEvent",
        "043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204",
    ),
    (
        "rcl_interfaces/msg/ParameterType",
        "df29ed057a834862187be24dd187d981790ff3ea6502f4cd27b432cbc42c6d46",
    ),
    (
        "rcl_interfaces/msg/ParameterValue",
        "115fc089a387e23c7ecd3525c9189c379109119d6ab82e8dfbde0fdf6a7f9b68",
    ),
    (
        "rcl_interfaces/msg/SetLoggerLevelsResult",
        "9316e5e679a5b72d2dd7fd80c539bae9e106fa0890a06dc5da3a8177a3ff6909",
    ),
    (
        "rcl_interfaces/msg/SetParametersResult",
        "cfcc0fb0371ee5159b403960ef4300f8f9d2f1fd6117c8666b7f9654d528a9b1",
    ),
    (
        "rmw_dds_common/msg/Gid",
        "ab6f21cfbb0a6dbb837161e1110c2051a2850ed9f9c53944d7115d9bcebedf71",
    ),
    (
        "rmw_dds_common/msg/NodeEntitiesInfo",
        "8ffef65ee2d088c63b1e8fcd31e800ba9fc8dbe0ee15ca60d1676de5218087a7",
    ),
    (
        "rmw_dds_common/msg/ParticipantEntitiesInfo",
        "91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e",
    ),
    (
        "rosgraph_msgs/msg/Clock",
        "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564",
    ),
    (
        "sensor_msgs/msg/FluidPressure",
        "22dfb2b145a0bd5a31a1ac3882a1b32148b51d9b2f3bab250290d66f3595bc32",
    ),
    (
        "sensor_msgs/msg/Imu",
        "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b",
    ),
    (
        "sensor_msgs/msg/JointState",
        "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
    ),
    (
        "service_msgs/msg/ServiceEventInfo",
        "41bcbbe07a75c9b52bc96bfd5c24d7f0fc0a08c0cb7921b3373c5732345a6f45",
    ),
    (
        "std_msgs/msg/Bool",
        "feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9",
    ),
    (
        "std_msgs/msg/Empty",
        "20b625256f32d5dbc0d04fee44f43c41e51c70d3502f84b4a08e7a9c26a96312",
    ),
    (
        "std_msgs/msg/Float64",
        "705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a",
    ),
    (
        "std_msgs/msg/Header",
        "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01",
    ),
    (
        "std_msgs/msg/String",
        "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    ),
    (
        "tf2_msgs/msg/TFMessage",
        "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    ),
    (
        "type_description_interfaces/msg/Field",
        "c0b01379cd4226281285ccaf6be46653968f855f7c5e41614ff5d7a854efef7c",
    ),
    (
        "type_description_interfaces/msg/FieldType",
        "a70b6dd919645a03a3586f7f821defbc886ea3e531a1d95cc0f380a3973ccaa6",
    ),
    (
        "type_description_interfaces/msg/IndividualTypeDescription",
        "55c827d86c3c141bdd318fe6c22e11190e4d3b37c8f4f9751a084aa05ce96560",
    ),
    (
        "type_description_interfaces/msg/KeyValue",
        "274fe56bf14f33c7512e34c646a37579ee36779f745f049a9760763e817f0c42",
    ),
    (
        "type_description_interfaces/msg/TypeDescription",
        "739f2508c9fa3a6f330913ff5b9d25fb74159a077da71e1087f51a60c12a080b",
    ),
    (
        "type_description_interfaces/msg/TypeSource",
        "faeaec7596c04ecf5b6e99ad225e4c7cbb997ad5435f793526fb3984d011aae5",
    ),
    (
        "unique_identifier_msgs/msg/UUID",
        "1b8e8aca958cbea28fe6ef60bf6c19b683c97a9ef60bb34752067d0f2f7ab437",
    ),
];

#[test]
fn every_standard_message_has_its_jazzy_hash() {
    for (name, hash) in MESSAGES {
        let info = type_info(name).unwrap_or_else(|| panic!("{name} is not generated"));
        assert_eq!(info.type_hash, format!("RIHS01_{hash}"), "{name}");
    }
}

#[test]
fn the_table_above_leaves_no_standard_message_out() {
    let known: Vec<&str> = MESSAGES.iter().map(|(name, _)| *name).collect();
    let standard: Vec<&str> = registry()
        .iter()
        .map(|info| info.type_name)
        .filter(|name| !name.starts_with("planesman_msgs/"))
        .collect();
    assert_eq!(known, standard);
}

fn assert_service<S: Service>(name: &str, hash: &str) {
    assert_eq!(S::TYPE_NAME, name);
    assert_eq!(S::TYPE_HASH, format!("RIHS01_{hash}"), "{name}");
}

#[test]
fn standard_services_have_their_jazzy_hashes() {
    use planesman_msgs::{action_msgs, rcl_interfaces, std_srvs, type_description_interfaces};

    assert_service::<action_msgs::srv::CancelGoal>(
        "action_msgs/srv/CancelGoal",
        "573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a",
    );
    assert_service::<rcl_interfaces::srv::DescribeParameters>(
        "rcl_interfaces/srv/DescribeParameters",
        "845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff",
    );
    assert_service::<rcl_interfaces::srv::GetParameterTypes>(
        "rcl_interfaces/srv/GetParameterTypes",
        "da199c878688b3e530bdfe3ca8f74cb9fa0c303101e980a9e8f260e25e1c80ca",
    );
    assert_service::<rcl_interfaces::srv::GetParameters>(
        "rcl_interfaces/srv/GetParameters",
        "bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc",
    );
    assert_service::<rcl_interfaces::srv::ListParameters>(
        "rcl_interfaces/srv/ListParameters",
        "3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d",
    );
    assert_service::<rcl_interfaces::srv::SetLoggerLevels>(
        "rcl_interfaces/srv/SetLoggerLevels",
        "3ff86cb4e91fbf9abae15c234ecc874448de6ece8e193401c077cf116e4f6d78",
    );
    assert_service::<rcl_interfaces::srv::SetParameters>(
        "rcl_interfaces/srv/SetParameters",
        "56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0",
    );
    assert_service::<rcl_interfaces::srv::SetParametersAtomically>(
        "rcl_interfaces/srv/SetParametersAtomically",
        "0e192ef259c07fc3c07a13191d27002222e65e00ccec653ca05e856f79285fcd",
    );
    assert_service::<std_srvs::srv::Empty>(
        "std_srvs/srv/Empty",
        "5888399dedec5ccc85ea6451949fd2c9f97bfdf963f9a588821639fcd31b5d19",
    );
    assert_service::<std_srvs::srv::SetBool>(
        "std_srvs/srv/SetBool",
        "abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
    );
    assert_service::<std_srvs::srv::Trigger>(
        "std_srvs/srv/Trigger",
        "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
    );
    assert_service::<type_description_interfaces::srv::GetTypeDescription>(
        "type_description_interfaces/srv/GetTypeDescription",
        "69b9c19c1021405984cc60dbbb1edceb147a6538b411d812ba6afabeed962cd5",
    );
}

fn assert_part<M: Message>(hash: &str) {
    assert_eq!(M::TYPE_HASH, format!("RIHS01_{hash}"), "{}", M::TYPE_NAME);
}

#[test]
fn requests_and_responses_have_their_jazzy_hashes() {
    use planesman_msgs::{rcl_interfaces, std_srvs, type_description_interfaces};

    assert_part::<rcl_interfaces::srv::ListParametersRequest>(
        "a1b0b5d6b967a5b8ac5bc8563c3ea678f349e312a6a4967227c5a96bc5ce38df",
    );
    assert_part::<rcl_interfaces::srv::ListParametersResponse>(
        "31b937b82de3612426be79f231e386259f97e8dc843e3f2845288b4bfa296bdd",
    );
    assert_part::<std_srvs::srv::SetBoolRequest>(
        "c62fbb99d94e1b25e8ef9e109f9581956bb1b3361a45a4e5810c36a90d29932e",
    );
    assert_part::<std_srvs::srv::SetBoolResponse>(
        "d0814e7f7b4880ab77e9c57426c7aa1562ab69f11eef8e2e968812f9cbd0b059",
    );
    assert_part::<std_srvs::srv::TriggerRequest>(
        "d010825374ce8918e72bfd826c82603e60f45419e932ea976f807b74a863a199",
    );
    assert_part::<std_srvs::srv::TriggerResponse>(
        "2d946c21e2fc3f1e9ca6986a8191d85fcc70097a8bb7771a053564bc47009cdf",
    );
    assert_part::<std_srvs::srv::EmptyRequest>(
        "458eaf200a3f63d9cc53d19436edebc0c140ef4c93ca75d5bd4ce19fd7759e35",
    );
    assert_part::<std_srvs::srv::EmptyResponse>(
        "0a2858b3f60df644a61d0fa44cfc923a3d3628e0ad9c8ad8534b1a2c92a413dc",
    );
    assert_part::<type_description_interfaces::srv::GetTypeDescriptionRequest>(
        "470f56ccbcf13d55c78c8b735fb12da03e639e5acded994426c89d94778d9e28",
    );
    assert_part::<type_description_interfaces::srv::GetTypeDescriptionResponse>(
        "648c49d976240861a482f961c5621ddd0d2135d8cce6f297a76d4f6376d93b75",
    );
}
