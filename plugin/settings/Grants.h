#pragma once

#include "haptics/base/text/MessageLog.h"
#include "haptics/base/text/Words.h"

#include <osgMidair/HapticSettings>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace osgMidair
{

/// Returns the path of the file \a name in \a folder, the folder of the file that names it; \a name
/// itself if it is absolute or doesn't exist there.
std::string nameBeside(const std::string& folder, const std::string& name);

/// Resolves the array, the thermometer and the recording of hands in \a settings beside the user's
/// own settings file, as nameBeside() does.
void lookBeside(const std::string& folder, HapticSettings& settings);

/// The user's grants: which devices, arrays and hand sources scene files may use.
///
/// A value from a file is a request. Without a grant only harmless ones are used: `sim:` and
/// `null:`, arrays by name or beside the scene, recordings of hands beside the scene, the mouse. A
/// grant is a name in a file that belongs to the user, or OSG_MIDAIR_TRUST=scene. Never granted:
/// `record:`, `play:`, an OpenXR loader or helper, an address to listen at, an absolute path, a
/// file above the scene's folder.
class Grants
{
public:
    /// Names and the values that replace them, such as "desk" and "usb:?max-amplitude=0.3".
    using Names = std::map<std::string, std::string>;

    explicit Grants(Names names = {}, bool trustsScenes = false);

    /// Reads the grants from OSG_MIDAIR_GRANTS or ~/.config/osgMidair/grants, and OSG_MIDAIR_TRUST.
    /// If the file is invalid or can't be trusted, \a messages get the reason and nothing in it is
    /// granted.
    static Grants ofUser(std::vector<midair::base::Message>& messages);

    /// Returns true if \a device, a URI or a list, names only simulated and null devices.
    static bool isHarmlessDevice(const std::string& device);

    /// Parses lines "name = value"; # begins a comment. Throws std::runtime_error, which names the
    /// line.
    static Names parse(const std::string& text);

    /// Returns \a settings with granted names replaced by their values, and requests without a
    /// grant by harmless values, each with a message. \a scene: name of the scene in messages. An
    /// array without a grant becomes empty: nothing is played.
    HapticSettings apply(HapticSettings settings,
                         const std::string& scene,
                         std::vector<midair::base::Message>& messages) const;

private:
    /// Reports that the scene's request of \a value for \a what is refused, and \a why.
    using Refuse = std::function<void(midair::base::MessageCode,
                                      const char* what,
                                      const std::string& value,
                                      const std::string& why)>;
    const std::string* find(const std::string& name) const;
    void applyDevice(HapticSettings& settings, const Refuse& refuse) const;
    void applyArray(HapticSettings& settings, const Refuse& refuse) const;
    void applyHands(HapticSettings& settings, const Refuse& refuse) const;
    void applyHeads(HapticSettings& settings, const Refuse& refuse) const;
    void applyThermometer(HapticSettings& settings, const Refuse& refuse) const;

    Names _names;
    bool _trustsScenes;
};

using midair::base::printable;

} // namespace osgMidair
