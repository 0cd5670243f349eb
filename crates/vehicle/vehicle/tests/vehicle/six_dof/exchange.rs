//! Blocks of Gazebo, Stonefish and DAVE: what is written is read back, and each fault is found.
//!
//! Signs in the blocks below are those of the simulators' documents and sources (src/six_dof/exchange/ names them), not of the writer.

use planesman_vehicle::six_dof::exchange::{
    Export, Finding, Format, Group, ModelNumbers, Named, ReadError, export, findings, read,
};
use planesman_vehicle::six_dof::{self, Matrix6};

const VEHICLES: [&str; 3] = ["bluerov2_heavy", "lauv", "remus_100_6dof"];

fn exported(name: &str, format: Format) -> (ModelNumbers, Export, ModelNumbers) {
    let vehicle = six_dof::load(name).unwrap();
    let export = export(&vehicle, format, format.density()).unwrap();
    let back = read(&export.text, None).unwrap_or_else(|e| panic!("{e}\n{}", export.text));
    assert_eq!(back.format, format);
    (ModelNumbers::of(&vehicle), export, back)
}

fn assert_near(what: &str, one: &[f64], other: &[f64]) {
    let largest = one.iter().map(|x| x.abs()).fold(1e-300, f64::max);
    for (x, y) in one.iter().zip(other) {
        assert!(
            (x - y).abs() <= 1e-12 * largest,
            "{what}: {one:?} {other:?}"
        );
    }
}

fn assert_matrix(what: &str, one: &Matrix6, other: &Matrix6) {
    assert_near(what, one.as_flattened(), other.as_flattened());
}

/// Body and buoyancy, which every format expresses.
fn assert_body(one: &ModelNumbers, other: &ModelNumbers) {
    let pair = |it: &ModelNumbers| [it.mass.unwrap(), it.displaced.unwrap()];
    assert_near("mass", &pair(one), &pair(other));
    assert_near(
        "inertia",
        one.inertia.unwrap().as_flattened(),
        other.inertia.unwrap().as_flattened(),
    );
    assert_near("gravity", &one.centre_of_gravity, &other.centre_of_gravity);
    assert_near(
        "buoyancy",
        &one.centre_of_buoyancy.unwrap(),
        &other.centre_of_buoyancy.unwrap(),
    );
}

fn diagonal(a: &Matrix6) -> Matrix6 {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { a[i][j] } else { 0.0 }))
}

#[test]
fn gazebo_gets_back_all_matrices_and_products_of_velocities() {
    for name in VEHICLES {
        let (ours, export, back) = exported(name, Format::Gazebo);
        assert_body(&ours, &back);
        assert_matrix(
            "added mass",
            &ours.added_mass.unwrap(),
            &back.added_mass.unwrap(),
        );
        assert_matrix("linear", &ours.damping.linear, &back.damping.linear);
        assert_matrix(
            "quadratic",
            &ours.damping.quadratic,
            &back.damping.quadratic,
        );
        let lost = ours
            .terms
            .iter()
            .filter(|it| !back.terms.contains(it))
            .count();
        let listed = export
            .omitted
            .iter()
            .filter(|it| it.contains("_uu "))
            .count();
        assert_eq!(lost, listed, "{name}: {:?}", export.omitted);
        assert_eq!(findings(&back), [], "{name}");
    }
}

#[test]
fn dave_gets_back_all_but_the_listed_couplings() {
    for name in VEHICLES {
        let (ours, export, back) = exported(name, Format::Dave);
        assert_body(&ours, &back);
        assert_matrix(
            "added mass",
            &ours.added_mass.unwrap(),
            &back.added_mass.unwrap(),
        );
        assert_matrix("linear", &ours.damping.linear, &back.damping.linear);
        let quadratic = &ours.damping.quadratic;
        assert_matrix("quadratic", &diagonal(quadratic), &back.damping.quadratic);
        let lost = quadratic
            .as_flattened()
            .iter()
            .filter(|x| **x != 0.0)
            .count()
            - diagonal(quadratic)
                .as_flattened()
                .iter()
                .filter(|x| **x != 0.0)
                .count();
        let listed = export
            .omitted
            .iter()
            .filter(|it| it.starts_with("quadratic_damping"))
            .count();
        assert_eq!(lost, listed, "{name}: {:?}", export.omitted);
        assert_eq!(findings(&back), [], "{name}");
    }
}

#[test]
fn stonefish_gets_back_the_body_and_the_drag_along_its_axes() {
    for name in VEHICLES {
        let (ours, export, back) = exported(name, Format::Stonefish);
        assert_body(&ours, &back);
        assert_eq!(back.added_mass, None);
        for (one, other) in [
            (&ours.damping.linear, &back.damping.linear),
            (&ours.damping.quadratic, &back.damping.quadratic),
        ] {
            let along = |a: &Matrix6| [a[0][0], a[1][1], a[2][2]];
            assert_near("drag", &along(one), &along(other));
        }
        assert!(export.omitted.iter().any(|it| it.starts_with("added mass")));
        assert_eq!(findings(&back), [], "{name}");
    }
}

#[test]
fn what_a_format_cannot_express_is_in_the_block_and_in_the_list() {
    let text = include_str!("general_body.yaml");
    let vehicle = six_dof::parse("general_body", text).unwrap();
    for format in [Format::Gazebo, Format::Stonefish, Format::Dave] {
        let export = export(&vehicle, format, 1000.0).unwrap();
        assert!(!export.omitted.is_empty());
        for it in &export.omitted {
            assert!(
                export.text.contains(&format!("Not expressed: {it}")),
                "{it}"
            );
        }
        let parts = vehicle.parts();
        let listed = |text: &str| export.omitted.iter().any(|it| it.contains(text));
        assert_eq!(listed("cross-flow"), !parts.cross_flow.is_empty());
        assert_eq!(listed("fins"), !parts.fins.is_empty());
        let body = ModelNumbers::of(&vehicle);
        let back = read(&export.text, Some(1000.0)).unwrap();
        if format != Format::Stonefish {
            assert_body(&body, &back);
            assert_matrix(
                "added",
                &body.added_mass.unwrap(),
                &back.added_mass.unwrap(),
            );
            assert_matrix("linear", &body.damping.linear, &back.damping.linear);
        }
    }
}

/// Gazebo's plugin with these entries, on a neutral body of 1 m^3.
fn gazebo(mass: f64, inertial: &str, plugin: &str) -> Vec<Finding> {
    let text = format!(
        r#"<sdf version="1.9"><model name="m"><link name="other"><inertial><mass>5</mass></inertial></link>
        <link name="hull"><inertial><mass>{mass}</mass>
        <inertia><ixx>100</ixx><iyy>200</iyy><izz>200</izz></inertia>{inertial}</inertial>
        <collision name="c"><pose>0 0 0.1 0 0 0</pose><geometry><box><size>2 1 0.5</size></box></geometry></collision></link>
        <plugin filename="gz-sim-hydrodynamics-system" name="gz::sim::systems::Hydrodynamics"><link_name>hull</link_name>
        <xUabsU>-10</xUabsU><yVabsV>-10</yVabsV><zWabsW>-10</zWabsW><kP>-10</kP><mQ>-10</mQ><nR>-10</nR>{plugin}</plugin></model></sdf>"#
    );
    findings(&read(&text, None).unwrap())
}

fn named(name: &str, value: f64) -> Named {
    Named(name.to_owned(), value)
}

#[test]
fn signs_of_gazebo_are_those_of_its_documents() {
    // Hydrodynamics.hh: xDotU and the like should be negative, fluid_added_mass positive, its example's damping negative.
    let physical = "<xDotU>-4.876</xDotU><yDotV>-126.3</yDotV><mDotQ>-33.46</mDotQ>";
    assert_eq!(gazebo(1000.0, "", physical), []);
    let fluid = "<fluid_added_mass><xx>4.876</xx><yy>126.3</yy><qq>33.46</qq></fluid_added_mass>";
    assert_eq!(gazebo(1000.0, fluid, ""), []);
    let twice = gazebo(1000.0, fluid, physical);
    assert!(
        matches!(twice[..], [Finding::AddedMassTwice(_)]),
        "{twice:?}"
    );
    let disabled = format!("{physical}<disable_added_mass>true</disable_added_mass>");
    assert_eq!(gazebo(1000.0, fluid, &disabled), []);
    let wrong = |group, name, value, sign| vec![Finding::Sign(group, named(name, value), sign)];
    let added = gazebo(1000.0, "", "<yDotV>126.3</yDotV>");
    assert_eq!(added, wrong(Group::AddedMass, "yDotV", 126.3, -1.0));
    let fluid = "<fluid_added_mass><yy>-126.3</yy></fluid_added_mass>";
    let expected = wrong(Group::AddedMass, "fluid_added_mass.yy", -126.3, 1.0);
    assert_eq!(gazebo(1000.0, fluid, ""), expected);
    let linear = gazebo(1000.0, "", "<yV>20</yV>");
    assert_eq!(linear, wrong(Group::Linear, "yV", 20.0, -1.0));
    let quadratic = gazebo(1000.0, "", "<nRabsR>3</nRabsR>");
    assert_eq!(quadratic, wrong(Group::Quadratic, "nRabsR", 3.0, -1.0));
    let square = gazebo(1000.0, "", "<xUU>-12</xUU>");
    assert_eq!(square, [Finding::Square(named("xUU", -12.0), 10.0)]);
    assert_eq!(gazebo(1000.0, "", "<xUU>-9</xUU>"), []);
}

#[test]
fn axes_of_gazebo_are_forward_port_up() {
    let text = r#"<model name="m"><link name="b"><inertial><pose>0.1 0.2 0.3 0 0 0</pose><mass>1</mass></inertial></link>
        <plugin name="gz::sim::systems::Hydrodynamics"><link_name>b</link_name><xW>-1</xW><yR>-2</yR><zWabsU>3</zWabsU></plugin></model>"#;
    let numbers = read(text, None).unwrap();
    assert_eq!(numbers.centre_of_gravity, [0.1, -0.2, -0.3]);
    // Surge per heave changes its sign with the axes, sway per yaw does not.
    assert_eq!(
        (numbers.damping.linear[0][2], numbers.damping.linear[1][5]),
        (-1.0, 2.0)
    );
    assert_eq!(numbers.terms[0].value, 3.0);
}

#[test]
fn masses_and_centres_that_are_not_physical_are_found() {
    let kind = |all: &[Finding]| all.iter().map(Finding::code).collect::<Vec<_>>();
    assert_eq!(kind(&gazebo(-1.0, "", ""))[0], "mass");
    assert_eq!(kind(&gazebo(880.0, "", "")), ["buoyancy"]);
    assert_eq!(gazebo(920.0, "", ""), []);
    let with = gazebo(1400.0, "", "<xDotU>-400</xDotU>");
    assert_eq!(
        with,
        [Finding::MassWithAddedMass(named("mass", 1400.0), 1000.0)]
    );
    let high = gazebo(1000.0, "<pose>0 0 0.3 0 0 0</pose>", "");
    let [Finding::MetacentricHeight(height)] = high[..] else {
        panic!("{high:?}");
    };
    assert!((height + 0.2).abs() < 1e-12, "{height}");
    let asymmetric = gazebo(1000.0, "", "<xDotR>-5</xDotR>");
    let entries = [named("xDotR", -5.0), named("added_mass_61", 0.0)];
    assert_eq!(asymmetric[0], Finding::Asymmetric(entries));
    let fluid = "<fluid_added_mass><xx>1</xx><yy>1</yy><xy>2000</xy></fluid_added_mass>";
    assert_eq!(kind(&gazebo(1000.0, fluid, "")), ["mass_matrix"]);
    let inertia = |xx: f64| {
        let text = format!(
            r#"<link name="b"><inertial><mass>1</mass><inertia><ixx>{xx}</ixx><iyy>1</iyy><izz>1</izz></inertia>
            <fluid_added_mass><xx>1</xx></fluid_added_mass></inertial></link>"#
        );
        findings(&read(&text, None).unwrap()).remove(0)
    };
    assert_eq!(inertia(2.1), Finding::Inertia([1.0, 1.0, 2.1]));
    assert!(matches!(inertia(1.9), Finding::NoDamping(0)));
}

#[test]
fn couplings_that_feed_energy_are_found_and_those_that_do_not_pass() {
    // The linear ones by the symmetric part: the mean of the pair against the square root of 20 x 10.
    let linear =
        |v: f64, r: f64| gazebo(1000.0, "", &format!("<yV>-20</yV><yR>{v}</yR><nV>{r}</nV>"));
    assert_eq!(linear(100.0, -100.0), []);
    assert_eq!(linear(28.0, 0.0), []);
    let Finding::Coupling(Group::Linear, entries, _) = &linear(29.0, 0.0)[0] else {
        panic!("{:?}", linear(29.0, 0.0));
    };
    assert_eq!(entries, &[named("yR", 29.0), named("nV", 0.0)]);
    // The quadratic ones by the power 10 t^3 - c t + 10, whose minimum is 10 - 2 c/3 sqrt(c/30): 0 at c = 10 (27/4)^(1/3) = 18.90.
    let quadratic = |c: f64| gazebo(1000.0, "", &format!("<yWabsW>{c}</yWabsW>"));
    assert_eq!(quadratic(18.8), []);
    assert!(matches!(
        quadratic(19.0)[..],
        [Finding::Coupling(Group::Quadratic, ..)]
    ));
}

/// DAVE's plugin on a link of 1028 kg.
fn dave(link: &str, model: &str) -> Vec<Finding> {
    let text = format!(
        r#"<robot name="r"><link name="r/base_link"><inertial><mass value="1028"/><origin xyz="0 0 0"/>
        <inertia ixx="100" ixy="0" ixz="0" iyy="200" iyz="0" izz="200"/></inertial></link>
        <gazebo><plugin name="uuv_plugin" filename="libuuv_underwater_object_ros_plugin.so"><link name="r/base_link">{link}
        <hydrodynamic_model><type>fossen</type>{model}</hydrodynamic_model></link></plugin></gazebo></robot>"#
    );
    findings(&read(&text, None).unwrap())
}

#[test]
fn signs_of_dave_are_those_of_its_source() {
    // HydrodynamicModel.cc: force = -M_A nu' + D nu + Q |nu| nu; RexROV and Caldus have added mass positive, damping negative.
    let physical = "<linear_damping>-74 -69 -728 -268 -309 -105</linear_damping>";
    let link = "<volume>1.0</volume><center_of_buoyancy>0 0 0.3</center_of_buoyancy>";
    assert_eq!(dave(link, physical), []);
    let positive = dave(
        link,
        "<linear_damping>-74 -69 728 -268 -309 -105</linear_damping>",
    );
    let expected = Finding::Sign(Group::Linear, named("linear_damping[3,3]", 728.0), -1.0);
    assert_eq!(positive, [expected]);
    let added = |x: f64| {
        let rest = "0 ".repeat(34);
        dave(
            link,
            &format!("{physical}<added_mass>{x} {rest} 1</added_mass>"),
        )
    };
    assert_eq!(added(779.0), []);
    let expected = Finding::Sign(Group::AddedMass, named("added_mass[1,1]", -779.0), 1.0);
    assert_eq!(added(-779.0), [expected]);
    // Up is positive for the centre of buoyancy; neutrally_buoyant replaces the volume.
    let below = link.replace("0 0 0.3", "0 0 -0.3");
    assert_eq!(dave(&below, physical), [Finding::MetacentricHeight(-0.3)]);
    let small = link.replace("1.0", "0.5");
    let [Finding::MassWithAddedMass(..) | Finding::Buoyancy(..)] = dave(&small, physical)[..]
    else {
        panic!("{:?}", dave(&small, physical));
    };
    let neutral = small + "<neutrally_buoyant>1</neutrally_buoyant>";
    assert_eq!(dave(&neutral, physical), []);
    assert_eq!(dave(link, "")[..].len(), 6);
}

#[test]
fn stonefish_ignores_a_negative_coefficient_and_its_sign_is_found() {
    let body = |drag: &str, kind: &str| {
        let text = format!(
            r#"<scenario><environment><ocean><water density="1025.0"/></ocean></environment><robot name="r">
            <base_link name="b" type="{kind}" physics="submerged"><dimensions xyz="2 1 0.5"/><origin xyz="0 0 -0.1" rpy="0 0 0"/>
            <mass value="1025"/><inertia xyz="100 200 200"/><cg xyz="0 0 0.1" rpy="0 0 0"/>
            <hydrodynamics viscous_drag="0.1 0.1 0.1" quadratic_drag="{drag}"/></base_link></robot></scenario>"#
        );
        read(&text, None).unwrap()
    };
    let numbers = body("0.2 0.6 0.6", "box");
    assert_eq!(findings(&numbers), []);
    // 1/2 rho C_d A with the front of 0.5 m^2; rho C_f S with the 2 (2 x 1 + 2 x 0.5) m^2 along x.
    assert!((numbers.damping.quadratic[0][0] - 0.5 * 1025.0 * 0.2 * 0.5).abs() < 1e-9);
    assert!((numbers.damping.linear[0][0] - 1025.0 * 0.1 * 6.0).abs() < 1e-9);
    for kind in ["box", "model"] {
        let found = findings(&body("0.2 -0.6 0.6", kind));
        let expected = Finding::Sign(Group::Quadratic, named("quadratic_drag.y", -0.6), 1.0);
        assert_eq!(found[0].entries(), expected.entries(), "{kind}");
    }
}

#[test]
fn files_that_are_no_vehicle_are_refused_with_their_entry() {
    let refused = |text: &str| read(text, None).unwrap_err();
    assert!(matches!(refused("<a><b></a>"), ReadError::Syntax(_)));
    assert_eq!(refused("<robot name='x'/>"), ReadError::Unknown);
    let macros =
        r#"<link name="b"><inertial><mass value="${mass}"/><fluid_added_mass/></inertial></link>"#;
    let said = refused(macros).to_string();
    assert!(
        said.contains("mass: '${mass}' is not 1 finite number(s)"),
        "{said}"
    );
    assert!(said.contains("xacro FILE"), "{said}");
    let short =
        "<link><hydrodynamic_model><added_mass>1 2 3</added_mass></hydrodynamic_model></link>";
    assert!(matches!(refused(short), ReadError::Number { .. }));
    let infinite = short.replace("added_mass>1 2 3", "linear_damping>1 2 3 4 inf 6");
    let infinite = infinite.replace("</added_mass", "</linear_damping");
    assert!(matches!(refused(&infinite), ReadError::Number { .. }));
    let compound = r#"<base_link type="compound"/>"#;
    assert!(matches!(refused(compound), ReadError::Unsupported { .. }));
    let deep = "<a>".repeat(20_000);
    assert!(matches!(refused(&deep), ReadError::Syntax(_)));
}

#[test]
fn an_undeclared_prefix_is_read_as_by_the_simulators() {
    let text = r#"<?xml version="1.0"?><!-- <a> --><sdf version="1.9"><link name="b"><inertial><mass>1</mass>
        <fluid_added_mass><xx>1</xx></fluid_added_mass></inertial><axis gz:expressed_in="x"/></link></sdf>"#;
    assert_eq!(read(text, None).unwrap().mass, Some(1.0));
}

#[test]
fn the_density_is_that_of_the_world_or_of_the_option() {
    let hull = r#"<link name="b"><inertial><mass>1</mass><fluid_added_mass><xx>1</xx></fluid_added_mass></inertial>
        <collision name="c"><geometry><cylinder><radius>1</radius><length>2</length></cylinder></geometry></collision></link>"#;
    let displaced = |world: &str, density| {
        let text = format!("<world>{world}{hull}</world>");
        read(&text, density).unwrap().displaced.unwrap() / (2.0 * std::f64::consts::PI)
    };
    let uniform = "<plugin><uniform_fluid_density>1020</uniform_fluid_density></plugin>";
    let graded = "<graded_buoyancy><default_density>1010</default_density></graded_buoyancy>";
    for (world, option, expected) in [
        (uniform, Some(1030.0), 1020.0),
        (graded, None, 1010.0),
        ("", Some(1030.0), 1030.0),
        ("", None, 1000.0),
    ] {
        assert!((displaced(world, option) - expected).abs() < 1e-9);
    }
}

#[test]
fn a_rounded_pair_is_symmetric() {
    let pair = |r: &str| {
        gazebo(
            1000.0,
            "",
            &format!("<xDotR>-10.775</xDotR><nDotU>{r}</nDotU>"),
        )
    };
    assert!(!matches!(pair("-10.774")[..], [Finding::Asymmetric(_), ..]));
    assert!(matches!(pair("-10.7")[..], [Finding::Asymmetric(_), ..]));
}

#[test]
fn names_are_escaped_in_the_block() {
    let vehicle = six_dof::load("lauv").unwrap();
    let mut parts = vehicle.parts().clone();
    parts.name = "a--b <\"&>".to_owned();
    parts.inputs[2] = "th<rust".to_owned();
    let vehicle = six_dof::Vehicle::new(parts).unwrap();
    for format in [Format::Gazebo, Format::Stonefish, Format::Dave] {
        read(&export(&vehicle, format, 1000.0).unwrap().text, None).unwrap();
    }
}
