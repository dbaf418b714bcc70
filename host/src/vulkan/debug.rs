//! Validation messages, object names and debug labels (VK_EXT_debug_utils).

use std::ffi::{CStr, CString, c_void};
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;

use super::error::VulkanError;

/// Validation layer of `--debug validation`.
pub(super) const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Errors and warnings that the validation layer reported; clones share the list.
#[derive(Clone, Debug, Default)]
pub struct Messages(Arc<Mutex<Vec<String>>>);

impl Messages {
    /// Removes and returns the messages since the last call.
    pub fn take(&self) -> Vec<String> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Fails with the new messages, if any.
    pub fn check(&self) -> Result<(), VulkanError> {
        let messages = self.take();
        if messages.is_empty() { Ok(()) } else { Err(VulkanError::Validation(messages)) }
    }

    /// Returns the creation info of a messenger that writes into this list. The list must outlive the messenger.
    pub(super) fn messenger(&self) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
        use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type};
        vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(Severity::ERROR | Severity::WARNING)
            .message_type(Type::VALIDATION | Type::PERFORMANCE)
            .pfn_user_callback(Some(receive))
            .user_data(Arc::as_ptr(&self.0).cast_mut().cast())
    }
}

unsafe extern "system" fn receive(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _type: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    list: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data, and `Messages::messenger` the list that the instance keeps alive.
    let (message, list) = unsafe {
        let message = (*data).message_as_c_str().map(CStr::to_string_lossy).unwrap_or_default();
        (message, &*list.cast::<Mutex<Vec<String>>>())
    };
    list.lock().unwrap_or_else(PoisonError::into_inner).push(format!("{severity:?}: {message}"));
    vk::FALSE
}

/// Object names and labels; without the extension all functions do nothing.
#[derive(Clone, Default)]
pub(super) struct Labels(pub(super) Option<ash::ext::debug_utils::Device>);

impl Labels {
    /// Names an object in messages and captures.
    pub(super) fn name(&self, object: impl vk::Handle, name: &str) {
        let (Some(device), Ok(name)) = (&self.0, CString::new(name)) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
        // SAFETY: the object is of this device and alive. A name that cannot be set is no error.
        let _ = unsafe { device.set_debug_utils_object_name(&info) };
    }

    /// Opens a region of a command buffer.
    pub(super) fn begin(&self, commands: vk::CommandBuffer, name: &str) {
        let (Some(device), Ok(name)) = (&self.0, CString::new(name)) else { return };
        let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
        // SAFETY: the command buffer is recording.
        unsafe { device.cmd_begin_debug_utils_label(commands, &label) };
    }

    /// Closes the region.
    pub(super) fn end(&self, commands: vk::CommandBuffer) {
        let Some(device) = &self.0 else { return };
        // SAFETY: the command buffer is recording and a region is open.
        unsafe { device.cmd_end_debug_utils_label(commands) };
    }
}

#[cfg(test)]
mod tests {
    use super::super::context::Context;
    use super::super::test_module;
    use super::*;

    #[test]
    fn a_wrong_call_makes_the_check_fail() {
        let context = match Context::new(None, false, true) {
            Ok(context) => context,
            Err(error) => return test_module::skip(&error),
        };
        context.messages().check().unwrap();
        // A buffer without any usage is forbidden and harmless.
        let info = vk::BufferCreateInfo::default().size(4);
        // SAFETY: the layer reports the mistake; the buffer is never bound to memory.
        unsafe {
            let buffer = context.raw.create_buffer(&info, None).unwrap();
            context.raw.destroy_buffer(buffer, None);
        }
        let error = context.messages().check().unwrap_err().to_string();
        assert!(error.contains("usage"), "{error}");
        context.messages().check().unwrap();
    }
}
