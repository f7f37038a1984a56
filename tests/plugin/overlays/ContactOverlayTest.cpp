#include "engine-bridge/pipeline/HologramResult.h"
#include "plugin/overlays/OverlayPart.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/ContactOverlay>
#include <osgMidair/HapticOverlays>

#include <osg/Geometry>

#include <memory>
#include <set>
#include <string>

#include <gtest/gtest.h>

using namespace osgMidair;
namespace bridge = midair::bridge;

namespace
{

/// A field with one contact, whose finger lies along x, 2 mm deep in a face at z = 0.
std::shared_ptr<bridge::HologramResult> touchedField(int foci)
{
    auto scene = std::make_shared<bridge::ContactScene>();
    bridge::ContactView contact;
    contact.id = 1;
    contact.share = 0.5;
    contact.patch.semiMajor_m = 6e-3;
    contact.patch.semiMinor_m = 4e-3;
    contact.patch.own = {{{-0.02, 0.0, 6e-3}, {0.02, 0.0, 6e-3}, 8e-3}};
    contact.pathMajor_m = 3e-3;
    contact.pathMinor_m = 2e-3;
    contact.foci = Eigen::Matrix3Xd::Zero(3, foci);
    contact.pressure_Pa = Eigen::VectorXd::Constant(foci, 800.0);
    scene->contacts = {contact};
    auto result = std::make_shared<bridge::HologramResult>();
    result->state = bridge::ArrayState::PLAYING;
    result->touched = scene;
    return result;
}

} // namespace

TEST(ContactOverlay, DrawsPatchPathAndFociAndLetsThemGo)
{
    osg::ref_ptr<ContactOverlay> overlay = new ContactOverlay;
    OverlayPart& part = OverlayPart::of(*overlay);
    part.setResult(touchedField(3));
    EXPECT_EQ(overlay->getNumContacts(), 1);
    EXPECT_EQ(overlay->getNumFoci(), 3);
    const osg::Geometry& lines = *overlay->getChild(0)->asGeometry();
    const osg::BoundingBox box = lines.getBoundingBox();
    EXPECT_NEAR(box.xMax(), 6e-3, 1e-5); // the patch's semi-axis
    EXPECT_NEAR(box.zMin(), -2e-3, 1e-5) << "the path is on the skin";
    const auto& colors = static_cast<const osg::Vec4ubArray&>(*lines.getColorArray());
    EXPECT_NEAR(colors.back().a(), 128, 1) << "faded by its share";
    part.setResult(touchedField(0));
    EXPECT_EQ(overlay->getNumContacts(), 0) << "near, but nothing is played";
    EXPECT_EQ(overlay->getNumFoci(), 0);
    EXPECT_TRUE(static_cast<const osg::Vec3Array&>(*lines.getVertexArray()).empty());
}

TEST(ContactOverlay, DrawsNothingThatIsNotPlayed)
{
    osg::ref_ptr<ContactOverlay> overlay = new ContactOverlay;
    const auto muted = touchedField(2);
    muted->state = bridge::ArrayState::MUTED;
    OverlayPart::of(*overlay).setResult(muted);
    EXPECT_EQ(overlay->getNumFoci(), 0);
    OverlayPart::of(*overlay).setResult(std::make_shared<bridge::HologramResult>());
    EXPECT_EQ(overlay->getNumContacts(), 0) << "a field without contacts";
}

TEST(ContactOverlay, IsOneOfAll)
{
    const osg::ref_ptr<HapticOverlays> all = new HapticOverlays;
    EXPECT_TRUE(dynamic_cast<ContactOverlay*>(all->getOverlay("contacts")));
    EXPECT_TRUE(all->getOverlay("Contacts")->isShown());
    EXPECT_EQ(all->get<ContactOverlay>(), all->getOverlay("contacts"));
    EXPECT_TRUE(all->setShown("contacts", false));
    EXPECT_FALSE(all->get<ContactOverlay>()->isShown());
    EXPECT_FALSE(all->isShown("Contacts"));
}

TEST(OverlaysByName, EachIsShownAndHiddenByEitherName)
{
    const osg::ref_ptr<HapticOverlays> all = new HapticOverlays;
    std::set<std::string> names;
    for (const OverlayDescription& one : HapticOverlays::describe())
    {
        EXPECT_TRUE(names.insert(one.name).second && names.insert(one.word).second) << one.name;
        EXPECT_EQ(all->getOverlay(one.name)->className(), one.node);
        EXPECT_FALSE(one.seen.empty()) << one.name;
        for (const bool shown : {true, false})
        {
            EXPECT_TRUE(all->setShown(shown ? one.name : one.word, shown));
            EXPECT_EQ(all->isShown(one.name), shown);
            EXPECT_EQ(all->isShown(one.word), shown);
            EXPECT_EQ(all->getOverlay(one.word)->isShown(), shown);
        }
    }
    EXPECT_EQ(all->showOnly({"contacts", "FieldSlice"}), "");
    for (const OverlayDescription& one : HapticOverlays::describe())
        EXPECT_EQ(all->isShown(one.name), one.word == "contacts" || one.word == "slice");
    EXPECT_EQ(all->showOnly({"none"}), "");
    EXPECT_FALSE(all->isShown("contacts"));
}

TEST(OverlaysByName, ANameThatNoneHasIsToldAndChangesNothing)
{
    const osg::ref_ptr<HapticOverlays> all = new HapticOverlays;
    const Notices notices;
    EXPECT_FALSE(all->setShown("contact", false));
    EXPECT_NE(notices.text().find("there is no overlay \"contact\" (did you mean contacts?)"),
              std::string::npos)
        << notices.text();
    EXPECT_FALSE(all->isShown("contact"));
    EXPECT_EQ(
        all->showOnly({"points", "fog"}).find("there is no overlay \"fog\"; there are points, "),
        0u);
    EXPECT_TRUE(all->isShown("slice")) << "nothing is hidden then";
}
