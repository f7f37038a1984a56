#pragma once

#include "engine-bridge/rendering/ContactRenderer.h"

namespace midair::bridge
{

/// The options for contacts of \a settings, of a scene's file or of the C interface; \a render: the
/// scene's.
template<typename S>
ContactRendererOptions contactsOf(const S& settings, Render render)
{
    ContactRendererOptions contacts;
    contacts.shares.render = render;
    contacts.shares.trackerError_m = settings.trackerError;
    contacts.tracker.path.rate_Hz = settings.contactRate;
    contacts.tracker.path.largestStep_m = settings.contactStep;
    contacts.tracker.path.mostFoci = settings.contactFoci;
    contacts.field.mask = settings.contactMask;
    return contacts;
}

} // namespace midair::bridge
