//! A file that people write in YAML: a ROS 2 parameter file, a value on the command line, a model file, any value.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use planesman_model_file::ModelFile;
use planesman_parameters::file;
use planesman_text::yaml;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = planesman_text::decoded(data) else {
        return;
    };
    let _ = yaml::from_str::<serde_yaml_ng::Value>(text);
    let _ = file::overrides_for(text, "/auv/plant_sim");
    let _ = file::parse_value("name", text);
    for name in ["model.yaml", "model.json"] {
        let path = Path::new(name);
        let _ = ModelFile::recognises(path, text);
        if let Ok(model) = ModelFile::parse(path, text) {
            assert_eq!(model.check(), Ok(()));
        }
    }
});
