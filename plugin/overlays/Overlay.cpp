#include "haptics/base/text/Words.h"
#include "plugin/overlays/OverlayPart.h"

#include <osgMidair/Overlay>

#include <osg/Notify>
#include <osgGA/GUIEventAdapter>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using Keys = osgGA::GUIEventAdapter;

/// Created by the first registration.
std::map<int, OverlayKind>& kinds()
{
    static std::map<int, OverlayKind> all;
    return all;
}

/// Returns why \a kind can't be registered; empty: it can.
std::string problemOf(const OverlayKind& kind)
{
    if (kind.name.empty() || kind.word.empty() || !kind.make)
        return "it has no name, no word or no maker";
    if (kind.key == Keys::KEY_F1 || kind.key == Keys::KEY_F7 || kind.key == Keys::KEY_F8)
        return kind.keyName() + " is reserved: it lists the keys, switches all overlays or mutes";
    for (const auto& [place, other] : kinds())
        if (place == kind.place || other.name == kind.name || other.word == kind.word ||
            (kind.key != 0 && other.key == kind.key))
            return "its place, name, word or key is taken by " + other.name;
    return {};
}

} // namespace

std::string OverlayKind::keyName() const
{
    if (key == 0) return {};
    if (key >= Keys::KEY_F1 && key <= Keys::KEY_F35)
        return fmt::format("F{}", key - Keys::KEY_F1 + 1);
    return key > ' ' && key < 0x7F ? std::string(1, static_cast<char>(key)) : std::to_string(key);
}

const std::map<int, OverlayKind>& overlayKinds()
{
    return kinds();
}

const OverlayKind* findOverlayKind(const std::string& name, std::string& error)
{
    std::vector<std::string> known;
    for (const auto& [place, kind] : kinds())
    {
        if (kind.isNamed(name)) return &kind;
        known.push_back(kind.word);
    }
    const std::string meant = midair::base::didYouMean(name, known);
    error =
        fmt::format("there is no overlay \"{}\"{}",
                    name,
                    meant.empty() ? fmt::format("; there are {}", fmt::join(known, ", ")) : meant);
    return nullptr;
}

OverlayRegistration::OverlayRegistration(const OverlayKind& kind)
{
    const std::string problem = problemOf(kind);
    if (problem.empty())
        kinds().emplace(kind.place, kind);
    else
        OSG_WARN << "osgMidair: the overlay \"" << kind.name << "\" is left out: " << problem
                 << std::endl;
}

OverlayPart& OverlayPart::of(Overlay& overlay)
{
    return *overlay._overlayPart;
}

Overlay::Overlay(std::unique_ptr<OverlayPart> part) : _overlayPart(std::move(part))
{
    setDataVariance(DYNAMIC);
}

Overlay::~Overlay() = default;

void Overlay::setShown(bool shown)
{
    setNodeMask(shown ? ~0U : 0U);
    dirtyBound();
}

// OSG's groups include the bounds of hidden children.
osg::BoundingSphere Overlay::computeBound() const
{
    return isShown() ? osg::Group::computeBound() : osg::BoundingSphere();
}

} // namespace osgMidair
