#pragma once

#include <osgMidair/HapticSettings>

#include <map>
#include <string>
#include <vector>

namespace osgMidair
{

/// What the user lets scene files name: a device, an array, hands.
///
/// What comes from a file is a wish. Without a grant it gets what hurts nobody: `sim:` and `null:`,
/// arrays by name or beside the scene, recordings of hands beside the scene. A grant is a name in a
/// file of the user's own, or OSG_MIDAIR_TRUST=scene. Never a wish's: `record:`, `play:`, an OpenXR
/// loader, an absolute path, a file above the scene's folder.
class Grants
{
public:
    /// Names and what they stand for, such as "desk" and "usb:?max-amplitude=0.3".
    using Names = std::map<std::string, std::string>;

    explicit Grants(Names names = {}, bool trustsScenes = false);

    /// Those of OSG_MIDAIR_GRANTS or ~/.config/osgMidair/grants, and OSG_MIDAIR_TRUST. What is
    /// wrong with them goes to \a messages, and nothing is granted then.
    static Grants ofUser(std::vector<std::string>& messages);

    /// Lines "name = value"; # begins a comment. Throws std::runtime_error naming the line.
    static Names parse(const std::string& text);

    /// \a settings as they count: names replaced by what they stand for, wishes that aren't granted
    /// by what is harmless, each told in \a messages. \a scene: what messages call it. An array
    /// that isn't granted is empty: nothing is played.
    HapticSettings apply(HapticSettings settings,
                         const std::string& scene,
                         std::vector<std::string>& messages) const;

private:
    struct Told;
    const std::string* find(const std::string& name) const;
    void applyDevice(HapticSettings& settings, const Told& told) const;
    void applyArray(HapticSettings& settings, const Told& told) const;
    void applyHands(HapticSettings& settings, const Told& told) const;

    Names _names;
    bool _trustsScenes;
};

/// \a text as it may be printed: without control characters, which a terminal would obey, and not
/// endless.
std::string printable(const std::string& text);

} // namespace osgMidair
