//! Vulkan loader and instance, with the validation layer on request.

use ash::{Entry, ext, vk};

use super::debug::{Messages, VALIDATION_LAYER};
use super::error::VulkanError;

/// Vulkan instance.
pub(super) struct Instance {
    pub(super) raw: ash::Instance,
    pub(super) physical_devices: Vec<vk::PhysicalDevice>,
    /// Whether VK_EXT_debug_utils is enabled.
    pub(super) debug_utils: bool,
    pub(super) messages: Messages,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    entry: Entry,
}

impl Instance {
    /// Loads Vulkan and lists its devices. With `validation`, the layer also validates synchronisation.
    pub(super) fn new(validation: bool) -> Result<Instance, VulkanError> {
        // SAFETY: loading libvulkan runs the initialisers of a library of the system.
        let entry =
            unsafe { Entry::load() }.map_err(|error| VulkanError::NoLoader { reason: error.to_string() })?;
        if validation && !has_validation_layer(&entry)? {
            return Err(VulkanError::NoValidationLayer);
        }

        // SAFETY: no layer is named.
        let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }.map_err(no_driver)?;
        let debug_utils =
            extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(ext::debug_utils::NAME));

        let messages = Messages::default();
        let layers = [VALIDATION_LAYER.as_ptr()];
        let names = [ext::debug_utils::NAME.as_ptr()];
        let application =
            vk::ApplicationInfo::default().application_name(c"caustics").api_version(vk::API_VERSION_1_2);
        let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
        let mut creation = messages.messenger();
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        if debug_utils {
            info = info.enabled_extension_names(&names);
        }
        if validation {
            info = info.enabled_layer_names(&layers).push_next(&mut features);
        }
        if validation && debug_utils {
            info = info.push_next(&mut creation);
        }

        // SAFETY: all that `info` points to lives until the call returns; `messages` outlives the instance.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(no_driver)?;
        let mut instance =
            Instance { raw, physical_devices: Vec::new(), debug_utils, messages, messenger: None, entry };
        if validation && debug_utils {
            instance.listen()?;
        }
        // SAFETY: the instance is alive.
        instance.physical_devices =
            unsafe { instance.raw.enumerate_physical_devices() }.map_err(no_driver)?;
        Ok(instance)
    }

    fn listen(&mut self) -> Result<(), VulkanError> {
        let debug = ext::debug_utils::Instance::new(&self.entry, &self.raw);
        // SAFETY: the extension is enabled, and `messages` outlives the messenger.
        let messenger = unsafe { debug.create_debug_utils_messenger(&self.messages.messenger(), None) }
            .map_err(VulkanError::call("vkCreateDebugUtilsMessengerEXT"))?;
        self.messenger = Some((debug, messenger));
        Ok(())
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: every object of the instance holds it, so all are gone.
        unsafe {
            if let Some((debug, messenger)) = &self.messenger {
                debug.destroy_debug_utils_messenger(*messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

fn has_validation_layer(entry: &Entry) -> Result<bool, VulkanError> {
    // SAFETY: the entry is loaded.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.map_err(no_driver)?;
    Ok(layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER)))
}

fn no_driver(result: vk::Result) -> VulkanError {
    VulkanError::NoDriver { reason: result.to_string() }
}
