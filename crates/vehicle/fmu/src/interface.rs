//! The C functions of FMI 3.0 (sections 2 and 4 of the standard): the only unsafe code, since C passes pointers.
//!
//! Callers in C are trusted only where no function can check them: that an instance was created here and not yet freed, that texts end with 0, and
//! that arrays have the given length. Everything else is checked: null, lengths, value references, types, numbers. A panic does not leave a function:
//! it becomes an error, and the instance is unchanged.

#![allow(
    unsafe_code,
    reason = "C hands over pointers, and finds functions by their names"
)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::ptr;

use planesman_parameters::Value;

use crate::instance::{Fault, Instance, Kept, misuse};
use crate::resources::Resources;

/// `fmi3Status`.
type Status = c_int;
const OK: Status = 0;
const DISCARD: Status = 2;
const ERROR: Status = 3;

/// The maximum number of values in one call: more than an FMU has variables.
const MOST_VALUES: usize = 1 << 16;

/// `fmi3LogMessageCallback`: environment, status, category, message.
type LogMessage = unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char);

/// The destination of messages.
#[derive(Clone, Copy)]
struct Log {
    message: Option<LogMessage>,
    environment: *mut c_void,
}

impl Log {
    fn put(&self, status: Status, text: &str) {
        let category = match status {
            DISCARD => c"logStatusDiscard",
            _ => c"logStatusError",
        };
        // A 0 within would end it.
        let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
        if let Some(message) = self.message {
            // SAFETY: the importer gave the function with its environment, and the texts live until it returns.
            unsafe { message(self.environment, status, category.as_ptr(), text.as_ptr()) };
        }
    }
}

/// The object behind `fmi3Instance`.
struct Handle {
    instance: Instance,
    log: Log,
    /// The texts returned by the last call; the importer may use them until the next.
    texts: Vec<CString>,
}

/// Runs a call on an instance, and returns its status.
fn call(
    instance: *mut c_void,
    name: &str,
    act: impl FnOnce(&mut Handle) -> Result<(), Fault>,
) -> Status {
    // SAFETY: an instance is null or one that `fmi3InstantiateCoSimulation` gave out; the importer calls one function of it at a time.
    let Some(handle) = (unsafe { instance.cast::<Handle>().as_mut() }) else {
        return ERROR;
    };
    let done = catch_unwind(AssertUnwindSafe(|| act(handle)));
    let fault = match done {
        Ok(Ok(())) => return OK,
        Ok(Err(fault)) => fault,
        Err(_) => misuse!("an error of Planesman's own; please report it"),
    };
    let status = match fault {
        Fault::Misuse(_) => ERROR,
        Fault::Discarded(_) => DISCARD,
    };
    handle.log.put(status, &format!("{name}: {fault}"));
    status
}

/// A text from C; `None` for null or invalid UTF-8.
///
/// # Safety
/// It is null or ends with 0.
unsafe fn text<'a>(text: *const c_char) -> Option<&'a str> {
    // SAFETY: as the caller says.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) }.to_str().ok())?
}

/// An array of `count` values from C, copied.
///
/// # Safety
/// It is null or has that length.
unsafe fn array<T: Copy>(array: *const T, count: usize, what: &str) -> Result<Vec<T>, Fault> {
    if count > 0 && array.is_null() {
        return Err(misuse!("{what} are null"));
    }
    if count > MOST_VALUES {
        return Err(misuse!("{count} {what}: at most {MOST_VALUES} are allowed"));
    }
    // SAFETY: as the caller says; C code need not align.
    Ok((0..count)
        .map(|i| unsafe { array.add(i).read_unaligned() })
        .collect())
}

/// The value references of a call, as many as the call has values.
///
/// # Safety
/// As for [`array`].
unsafe fn references(given: *const u32, count: usize, values: usize) -> Result<Vec<u32>, Fault> {
    if count != values {
        return Err(misuse!(
            "{count} value references but {values} values: every variable has one number or text"
        ));
    }
    // SAFETY: as the caller says.
    unsafe { array(given, count, "value references") }
}

/// Copies values to an array of C; `of` converts a value to C, if it has the type.
///
/// # Safety
/// The arrays are null or have the given length.
unsafe fn get<T: Copy>(
    handle: &mut Handle,
    given: (*const u32, usize),
    values: (*mut T, usize),
    of: impl FnMut(&Value) -> Option<T>,
) -> Result<(), Fault> {
    // SAFETY: as the caller says.
    let references = unsafe { references(given.0, given.1, values.1) }?;
    if !references.is_empty() && values.0.is_null() {
        return Err(misuse!("values are null"));
    }
    let read = handle.instance.get(&references)?;
    let read: Option<Vec<T>> = read.iter().map(of).collect();
    let read =
        read.ok_or_else(|| misuse!("a variable has another type; see modelDescription.xml"))?;
    for (i, value) in read.into_iter().enumerate() {
        // SAFETY: there are as many places as values.
        unsafe { values.0.add(i).write_unaligned(value) };
    }
    Ok(())
}

/// Sets values from an array of C.
///
/// # Safety
/// The arrays are null or have the given length.
unsafe fn set<T: Copy>(
    handle: &mut Handle,
    given: (*const u32, usize),
    values: (*const T, usize),
    of: impl FnMut(T) -> Result<Value, Fault>,
) -> Result<(), Fault> {
    // SAFETY: as the caller says.
    let (references, values) = unsafe {
        (
            references(given.0, given.1, values.1)?,
            array(values.0, values.1, "values")?,
        )
    };
    let values: Vec<Value> = values.into_iter().map(of).collect::<Result<_, _>>()?;
    handle
        .instance
        .set(references.into_iter().zip(values).collect())
}

/// Defines a C function `(instance, arguments) -> status` that acts on a handle.
macro_rules! functions {
    ($($name:ident($($argument:ident: $kind:ty),*) $act:expr;)*) => {$(
        #[doc = concat!("`", stringify!($name), "` of FMI 3.0.")]
        ///
        /// # Safety
        /// The instance is null or was created here and not freed; arrays are null or have the given length.
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(instance: *mut c_void, $($argument: $kind),*) -> Status {
            call(instance, stringify!($name), $act)
        }
    )*};
}

/// Defines functions that this FMU does not support, as its description says. The arguments of these functions belong to the caller, and are not
/// used.
macro_rules! without {
    ($($name:ident)*) => {$(
        #[doc = concat!("`", stringify!($name), "` of FMI 3.0: it has no effect here.")]
        ///
        /// # Safety
        /// The instance is null or was created here and not freed.
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(instance: *mut c_void) -> Status {
            call(instance, stringify!($name), |_| Err(misuse!("this FMU supports only co-simulation, without events, clocks and derivatives")))
        }
    )*};
}

/// Defines reading and setting of types that no variable has; only empty calls succeed.
macro_rules! absent {
    ($($name:ident)*) => {$(
        #[doc = concat!("`", stringify!($name), "` of FMI 3.0: no variable has this type.")]
        ///
        /// # Safety
        /// The instance is null or was created here and not freed.
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(instance: *mut c_void, _: *const c_void, count: usize) -> Status {
            call(instance, stringify!($name), |_| match count {
                0 => Ok(()),
                _ => Err(misuse!("no variable of this FMU has this type")),
            })
        }
    )*};
}

/// `fmi3GetVersion`.
#[unsafe(no_mangle)]
extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// `fmi3InstantiateCoSimulation`: null, with a message, if the FMU's resources were changed after it was written.
///
/// # Safety
/// Texts are null or end with 0; the callback can be called with the environment.
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _instance_name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: u8,
    _logging_on: u8,
    event_mode_used: u8,
    _early_return_allowed: u8,
    _intermediate_variables: *const u32,
    _intermediate_count: usize,
    environment: *mut c_void,
    message: Option<LogMessage>,
    _intermediate_update: *const c_void,
) -> *mut c_void {
    let log = Log {
        message,
        environment,
    };
    let made = catch_unwind(|| {
        // SAFETY: as the caller says.
        let (token, folder) = unsafe { (text(token), text(resources)) };
        let folder = folder.ok_or("resourcePath is null or not UTF-8")?;
        let resources = Resources::read(Path::new(folder)).map_err(|it| it.to_string())?;
        match token == Some(&*resources.token) {
            true => Ok(resources),
            false => Err(
                "instantiationToken does not match the files in resources: export the FMU again"
                    .to_owned(),
            ),
        }
    });
    let made = match made {
        Ok(Ok(_)) if event_mode_used != 0 => Err("this FMU has no event mode".to_owned()),
        Ok(made) => made,
        Err(_) => Err("an error of Planesman's own; please report it".to_owned()),
    };
    match made {
        Ok(resources) => {
            let handle = Handle {
                instance: Instance::new(resources),
                log,
                texts: Vec::new(),
            };
            Box::into_raw(Box::new(handle)).cast()
        }
        Err(reason) => {
            log.put(ERROR, &format!("fmi3InstantiateCoSimulation: {reason}"));
            ptr::null_mut()
        }
    }
}

/// `fmi3InstantiateModelExchange`: null, since the FMU supports co-simulation only.
#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateModelExchange() -> *mut c_void {
    ptr::null_mut()
}

/// `fmi3InstantiateScheduledExecution`: null, since the FMU supports co-simulation only.
#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateScheduledExecution() -> *mut c_void {
    ptr::null_mut()
}

/// `fmi3FreeInstance`.
///
/// # Safety
/// The instance is null or was created here and not freed.
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3FreeInstance(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: it came from `Box::into_raw`.
        drop(unsafe { Box::from_raw(instance.cast::<Handle>()) });
    }
}

functions! {
    fmi3SetDebugLogging(_logging_on: u8, _count: usize, _categories: *const *const c_char) |_| Ok(());
    fmi3EnterInitializationMode(
        _tolerance_defined: u8, _tolerance: f64, start: f64, _stop_defined: u8, _stop: f64
    ) |it| it.instance.enter_initialisation(start);
    fmi3ExitInitializationMode() |it| it.instance.exit_initialisation();
    fmi3Terminate() |it| it.instance.terminate();
    fmi3Reset() |it| {
        it.instance.reset();
        Ok(())
    };
    fmi3DoStep(
        from: f64, step: f64, _no_set_prior: u8,
        event_needed: *mut u8, terminate: *mut u8, early: *mut u8, last: *mut f64
    ) |it| {
        let done = it.instance.step(from, step);
        for flag in [event_needed, terminate, early] {
            if !flag.is_null() {
                // SAFETY: the importer's place for the answer.
                unsafe { flag.write(0) };
            }
        }
        if !last.is_null() {
            // SAFETY: the same.
            unsafe { last.write_unaligned(it.instance.time()) };
        }
        done
    };
    fmi3GetFloat64(references: *const u32, count: usize, values: *mut f64, value_count: usize)
        // SAFETY: as the importer says, here and below.
        |it| unsafe { get(it, (references, count), (values, value_count), |value| match value {
            Value::Double(number) => Some(*number),
            _ => None,
        }) };
    fmi3GetInt64(references: *const u32, count: usize, values: *mut i64, value_count: usize)
        |it| unsafe { get(it, (references, count), (values, value_count), |value| match value {
            Value::Integer(number) => Some(*number),
            _ => None,
        }) };
    fmi3GetBoolean(references: *const u32, count: usize, values: *mut u8, value_count: usize)
        |it| unsafe { get(it, (references, count), (values, value_count), |value| match value {
            Value::Bool(is) => Some(u8::from(*is)),
            _ => None,
        }) };
    fmi3GetString(references: *const u32, count: usize, values: *mut *const c_char, value_count: usize)
        |it| {
            let mut texts = Vec::new();
            let got = unsafe { get(it, (references, count), (values, value_count), |value| match value {
                Value::String(text) => {
                    let text = CString::new(text.replace('\0', " ")).ok()?;
                    let at = text.as_ptr();
                    texts.push(text);
                    Some(at)
                }
                _ => None,
            }) };
            it.texts = texts;
            got
        };
    fmi3SetFloat64(references: *const u32, count: usize, values: *const f64, value_count: usize)
        |it| unsafe { set(it, (references, count), (values, value_count), |value| Ok(Value::Double(value))) };
    fmi3SetInt64(references: *const u32, count: usize, values: *const i64, value_count: usize)
        |it| unsafe { set(it, (references, count), (values, value_count), |value| Ok(Value::Integer(value))) };
    fmi3SetBoolean(references: *const u32, count: usize, values: *const u8, value_count: usize)
        |it| unsafe { set(it, (references, count), (values, value_count), |value| Ok(Value::Bool(value != 0))) };
    fmi3SetString(references: *const u32, count: usize, values: *const *const c_char, value_count: usize)
        |it| unsafe { set(it, (references, count), (values, value_count), |value| {
            let text = text(value).ok_or_else(|| misuse!("a text is null or not UTF-8"))?;
            Ok(Value::String(text.to_owned()))
        }) };
    fmi3GetFMUState(state: *mut *mut c_void) |it| {
        if state.is_null() {
            return Err(misuse!("the pointer for the state is null"));
        }
        // SAFETY: the importer's place; it is null or a state that this function gave out, which is written anew.
        match unsafe { (*state).cast::<Kept>().as_mut() } {
            Some(kept) => *kept = it.instance.keep(),
            // SAFETY: the same.
            None => unsafe { *state = Box::into_raw(Box::new(it.instance.keep())).cast() },
        }
        Ok(())
    };
    fmi3SetFMUState(state: *mut c_void) |it| {
        // SAFETY: null or a state that was given out and not freed.
        let kept = unsafe { state.cast::<Kept>().as_ref() };
        it.instance.go_back(kept.ok_or_else(|| misuse!("the state is null"))?);
        Ok(())
    };
    fmi3FreeFMUState(state: *mut *mut c_void) |_| {
        // SAFETY: null, or a place with null or with a state that was given out and not freed.
        unsafe {
            if !state.is_null() && !(*state).is_null() {
                drop(Box::from_raw((*state).cast::<Kept>()));
                *state = ptr::null_mut();
            }
        }
        Ok(())
    };
}

absent! {
    fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetInt32 fmi3GetUInt32 fmi3GetUInt64 fmi3GetBinary fmi3GetClock
    fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt16 fmi3SetInt32 fmi3SetUInt32 fmi3SetUInt64 fmi3SetBinary fmi3SetClock
}

without! {
    fmi3EnterEventMode fmi3EnterStepMode fmi3EnterConfigurationMode fmi3ExitConfigurationMode
    fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies
    fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState
    fmi3GetDirectionalDerivative fmi3GetAdjointDerivative fmi3GetOutputDerivatives
    fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetShiftDecimal fmi3GetShiftFraction
    fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction
    fmi3EvaluateDiscreteStates fmi3UpdateDiscreteStates fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep fmi3SetTime
    fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators fmi3GetContinuousStates
    fmi3GetNominalsOfContinuousStates fmi3GetNumberOfEventIndicators fmi3GetNumberOfContinuousStates fmi3ActivateModelPartition
}
