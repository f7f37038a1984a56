// Arrays that Ultraino's simulator has saved, as Java's XMLEncoder writes them.
#include "samples/tools/device/UltrainoSimulation.h"

#include "haptics/base/InputError.h"

#include <Eigen/Geometry>

#include <functional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <zlib.h>

using namespace midair;
using namespace midair::samples;

namespace
{

std::string gzip(const std::string& text)
{
    z_stream stream{};
    EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY), Z_OK);
    std::string out(deflateBound(&stream, text.size()) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream.avail_in = static_cast<uInt>(text.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

/// field \a name of the object \a id, as the encoder sets public fields.
std::string field(const std::string& kind,
                  const std::string& id,
                  const std::string& name,
                  const std::string& value)
{
    return "<void class=\"acousticfield3d." + kind + "\" method=\"getField\"><string>" + name +
           "</string><void method=\"set\"><object idref=\"" + id + "\"/>" + value +
           "</void></void>\n";
}

std::string real(double value)
{
    return "<float>" + std::to_string(value) + "</float>";
}

std::string property(const std::string& name, const std::string& value)
{
    return "<void property=\"" + name + "\">" + value + "</void>\n";
}

struct One
{
    double x = 0, y = 0, z = 0;
    int pin = -1;   ///< -1: not in the file
    int order = -1; ///< the same
    std::string more = {};
    std::string turn = {};
};

/// A transducer; its first one has the next ones in its tag, as objects are defined where they are
/// met first.
std::string transducer(int number, const One& one, const std::string& inTag)
{
    const std::string id = "Transducer" + std::to_string(number);
    const std::string at = "Vector3f" + std::to_string(number);
    const std::string whole = "simulation.Transducer";
    std::string text = "<void class=\"acousticfield3d.simulation.Transducer\" id=\"" + id + "\">\n";
    text += field(whole, id, "name", "<string>t</string>");
    if (one.pin >= 0)
        text += property("driverPinNumber", "<int>" + std::to_string(one.pin) + "</int>");
    if (one.order >= 0)
        text += property("orderNumber", "<int>" + std::to_string(one.order) + "</int>");
    if (number == 0) text += "<void id=\"Integer0\" property=\"shader\"/>\n";
    text += property("tag", inTag + "<object idref=\"Integer0\"/>");
    text += one.more;
    text += "<void id=\"Transform" + std::to_string(number) + "\" property=\"transform\">" +
            one.turn + "<void id=\"" + at + "\" property=\"translation\">";
    // What is 0 isn't written.
    if (one.x != 0) text += field("math.Vector3f", at, "x", real(one.x));
    if (one.y != 0) text += field("math.Vector3f", at, "y", real(one.y));
    if (one.z != 0) text += field("math.Vector3f", at, "z", real(one.z));
    return text + "</void></void></void>\n";
}

std::string simulation(const std::vector<One>& all)
{
    std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                       "<java version=\"11.0.9\" class=\"java.beans.XMLDecoder\">\n"
                       "<object class=\"acousticfield3d.simulation.Simulation\" id=\"Simulation0\">"
                       "<void property=\"minSize\"><float>0.003</float></void></object>\n";
    std::string inner;
    for (std::size_t i = all.size(); i-- > 1;)
        inner = transducer(static_cast<int>(i), all[i], i + 1 < all.size() ? inner : "");
    // The first one is met as what a vector's field is set to, of all things.
    text += "<void class=\"acousticfield3d.math.Vector3f\" method=\"getField\"><string>x</string>"
            "<void method=\"set\">" +
            transducer(0, all[0], inner) +
            "<void idref=\"Transform0\"/><object idref=\"Vector3f0\"/>" + real(all[0].x) +
            "</void></void>\n";
    text += "<void class=\"acousticfield3d.simulation.Simulation\" method=\"getField\">"
            "<string>transducers</string><void id=\"ArrayList0\" method=\"get\">"
            "<object idref=\"Simulation0\"/>";
    for (std::size_t i = 0; i < all.size(); ++i)
        text +=
            "<void method=\"add\"><object idref=\"Transducer" + std::to_string(i) + "\"/></void>";
    return text + "</void></void><void idref=\"ArrayList0\"/></java>\n";
}

UltrainoSimulation read(const std::vector<One>& all)
{
    return readUltraino(gzip(simulation(all)), "array.xml.gz");
}

std::string refusal(const std::string& bytes)
{
    try
    {
        readUltraino(bytes, "array.xml.gz");
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return "nothing";
}

std::string refusalOf(const std::vector<One>& all)
{
    return refusal(simulation(all));
}

} // namespace

TEST(UltrainoSimulation, PlacesStandByTheirPinsWithTheirEmissionUpwards)
{
    const UltrainoSimulation made =
        read({{0.01, 0.02, 0.03, 1}, {0, 0, -0.05, 0}, {0.02, 0, 0, 2}});
    const haptics::TransducerArray& array = made.array;
    EXPECT_EQ(made.notes, std::vector<std::string>());
    ASSERT_EQ(array.size(), 3);
    // y is up in the simulator, z in array files.
    EXPECT_TRUE(array.positions.col(1).isApprox(Eigen::Vector3d(0.01, -0.03, 0.02), 1e-6));
    EXPECT_TRUE(array.positions.col(0).isApprox(Eigen::Vector3d(0, 0.05, 0), 1e-6));
    EXPECT_TRUE(array.normals.col(0).isApprox(Eigen::Vector3d::UnitZ()));
    EXPECT_EQ(array.frequency_Hz, 40e3);
    EXPECT_TRUE(array.isValid());
    EXPECT_EQ(readUltraino(simulation({{0.5, 0, 0, 0}}), "plain").array.positions(0, 0), 0.5);
}

TEST(UltrainoSimulation, RotationsGainsAndCorrectionsAreTaken)
{
    One turned;
    turned.pin = 0;
    // By 90 degrees about x: from y, upwards, to z, which is -y of the array.
    turned.turn =
        property("rot", property("w", real(std::sqrt(0.5))) + property("x", real(std::sqrt(0.5))));
    turned.more = field("simulation.Transducer", "Transducer0", "power", real(1.2)) +
                  field("simulation.Transducer", "Transducer0", "phaseCorrection", real(0.5));
    One plain;
    plain.pin = 1;
    plain.more = field("simulation.Transducer", "Transducer1", "power", real(2.4));
    const haptics::TransducerArray array = read({turned, plain}).array;
    EXPECT_TRUE(array.normals.col(0).isApprox(-Eigen::Vector3d::UnitY(), 1e-5));
    EXPECT_NEAR(array.gain[0], 0.5, 1e-9);
    EXPECT_NEAR(array.gain[1], 1.0, 1e-9);
    EXPECT_EQ(array.sourceAmplitude_Pa_m, 10.1)
        << "a part's loudness is never below the data sheet's";
    EXPECT_NEAR(array.phaseOffset_rad[0], 1.5707963, 1e-6);
}

TEST(UltrainoSimulation, WiresWithoutATransducerAreDead)
{
    const UltrainoSimulation made = read({{0.01, 0, 0, 2}, {0.03, 0, 0, 65}});
    ASSERT_EQ(made.array.size(), 128) << "whole boards of 64";
    EXPECT_EQ(made.array.dead.size(), 126U);
    EXPECT_NEAR(made.array.positions(0, 65), 0.03, 1e-9);
    EXPECT_NEAR(made.array.positions(0, 0), 0.02, 1e-9);
    ASSERT_EQ(made.notes.size(), 1U);
    EXPECT_NE(made.notes[0].find("126 of 128 channels have no transducer"), std::string::npos);
}

TEST(UltrainoSimulation, WithoutPinsTheOrderCounts)
{
    const UltrainoSimulation made = read({{0.01, 0, 0, -1, 1}, {0.02, 0, 0, -1, -1}});
    EXPECT_NEAR(made.array.positions(0, 1), 0.01, 1e-9);
    EXPECT_NEAR(made.array.positions(0, 0), 0.02, 1e-9) << "0 isn't written";
    ASSERT_EQ(made.notes.size(), 1U);
    EXPECT_NE(made.notes[0].find("by orderNumber"), std::string::npos) << made.notes[0];
    EXPECT_EQ(read({{0.01}, {0.02}}).notes[0].find("neither pins nor orderNumber"), 0U);
    // A number that a getter has named: the shader's, 2.
    One named{0.03};
    named.more = property("orderNumber", "<object idref=\"Integer0\"/>");
    EXPECT_NEAR(read({{0.01}, {0.02, 0, 0, -1, 1}, named}).array.positions(0, 2), 0.03, 1e-9);
}

TEST(UltrainoSimulation, WhatIsWrongIsNamed)
{
    One wrong{0.01};
    wrong.more = field("simulation.Transducer", "Transducer0", "power", "<float>NaN</float>");
    EXPECT_EQ(
        refusalOf({wrong}),
        "array.xml.gz: power of transducer 0 is nan; it must be a number from 1e-06 to 10000");
    wrong.more = property("orderNumber", "<int>-7</int>");
    EXPECT_EQ(refusalOf({wrong}), "nothing") << "one that isn't wired";
    wrong.more = field("simulation.Transducer", "Transducer0", "frequency", real(25e3));
    EXPECT_EQ(refusalOf({wrong, One{0.02}})
                  .find("array.xml.gz: transducer 1 has 40000 Hz, those before it 25000"),
              0U);
    EXPECT_EQ(refusalOf({{11.0}}),
              "array.xml.gz: x of transducer 0 is 11; it must be a number from -10 to 10");
    EXPECT_EQ(refusalOf({{0.01, 0, 0, 900000}}),
              "array.xml.gz: a transducer has the pin 900000; it must be below 4096");
    const std::string good = simulation({{0.01}});
    EXPECT_EQ(refusal("<java class=\"java.beans.XMLDecoder\"/>"),
              "array.xml.gz: it has no Simulation");
    EXPECT_NE(refusal("<html/>").find("java.beans.XMLDecoder"), std::string::npos);
    EXPECT_NE(refusal(good.substr(0, 300)).find("array.xml.gz, line "), std::string::npos);
    EXPECT_NE(refusal("<java class=\"java.beans.XMLDecoder\"><void idref=\"X\"/></java>")
                  .find("it refers to \"X\" before"),
              std::string::npos);
    EXPECT_NE(refusal("<!DOCTYPE a [<!ENTITY b \"c\">]><java/>").find("it has a document type"),
              std::string::npos);
    std::string deep;
    for (int i = 0; i < 70; ++i)
        deep += "<void>";
    EXPECT_NE(refusal("<java>" + deep).find("more than 64 deep"), std::string::npos);
    std::string many = "<java>";
    for (int i = 0; i < 500001; ++i)
        many += "<a/>";
    EXPECT_NE(refusal(gzip(many + "</java>")).find("it has more than 500000 elements"),
              std::string::npos);
}

TEST(UltrainoSimulation, CompressionIsBoundedAndChecked)
{
    const std::string bomb = gzip("<java>" + std::string(kMostUltrainoXml + 1000, ' '));
    ASSERT_LT(bomb.size(), 1000000U);
    EXPECT_EQ(refusal(bomb), "array.xml.gz: it holds more than 67108864 bytes");
    const std::string good = gzip(simulation({{0.01}}));
    EXPECT_EQ(refusal(good), "nothing");
    EXPECT_EQ(refusal(good.substr(0, good.size() / 2)).find("array.xml.gz: the compressed data"),
              0U);
}

// Each is read as a valid array or refused by name; none ends the program.
TEST(UltrainoSimulation, DamagedFilesAreArraysOrRefused)
{
    const std::string good = simulation({{0.01, 0, 0, 1}, {0.02, 0.01, 0, 0}, {0, 0, 0.03, 2}});
    const std::string packed = gzip(good);
    std::minstd_rand random(7);
    int read = 0;
    const auto attempt = [&](const std::string& bytes)
    {
        try
        {
            EXPECT_TRUE(readUltraino(bytes, "array.xml.gz").array.isValid());
            ++read;
        }
        catch (const base::InputError& error)
        {
            EXPECT_EQ(std::string(error.what()).find("array.xml.gz"), 0U) << error.what();
        }
    };
    for (int k = 0; k < 3000; ++k)
    {
        std::string text = good;
        for (unsigned int change = 0; change <= random() % 3; ++change)
        {
            const std::size_t at = random() % text.size();
            const std::size_t other = random() % text.size();
            if (random() % 2 == 0)
                text[at] = static_cast<char>(random());
            else
                text = text.substr(0, at) + text.substr(other, random() % 200) + text.substr(at);
        }
        attempt(text);
    }
    EXPECT_GT(read, 100);
    for (std::size_t cut = 0; cut < packed.size(); ++cut)
        attempt(packed.substr(0, cut));
    for (std::size_t at = 0; at < packed.size(); ++at)
    {
        std::string text = packed;
        text[at] = static_cast<char>(text[at] ^ (1 << random() % 8));
        attempt(text);
    }
}
