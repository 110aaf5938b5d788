#include "tests/capture/gige_features.h"

#include "capture/aravis/gobject.h"
#include "core/text.h"
#include "tests/capture/fake_gige_camera.h"

namespace floatstage::capture {
namespace {

std::string integer_register(const std::string& name, int address) {
  return text("<IntReg Name=\"", name, "\"><Address>", address,
              "</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>"
              "<Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>");
}

}  // namespace

std::filesystem::path described_with(const std::string& features, const TempFolder& folder) {
  const FakeGigeCamera plain(1, "PLAIN");
  const GObjectPtr<ArvCamera> camera(arv_camera_new(plain.address().c_str(), nullptr));
  std::size_t size = 0;
  const char* xml = arv_device_get_genicam_xml(arv_camera_get_device(camera.get()), &size);
  std::string description(xml, size);
  description.insert(description.find("<Port Name=\"Device\""), features);
  return folder.write("camera.xml", description);
}

std::string ptp_features(const std::string& follows) {
  return text(
      "<Boolean "
      "Name=\"PtpEnable\"><pValue>Enable</pValue><OnValue>1</OnValue><OffValue>0</OffValue></Boolean>"
      "<Command Name=\"PtpDataSetLatch\"><pValue>Latch</pValue><CommandValue>1</CommandValue></Command>"
      "<Enumeration Name=\"PtpStatus\"><EnumEntry Name=\"Listening\"><Value>0</Value></EnumEntry>"
      "<EnumEntry Name=\"Slave\"><Value>1</Value></EnumEntry><pValue>",
      follows, "</pValue></Enumeration><Integer Name=\"PtpOffsetFromMaster\"><Value>-250</Value></Integer>",
      integer_register("Enable", 0x8000), integer_register("Latch", 0x8004),
      integer_register("Never", 0x8008));
}

std::string white_balance_features() {
  return text(
      "<Enumeration Name=\"BalanceRatioSelector\"><EnumEntry Name=\"Red\"><Value>0</Value></EnumEntry>"
      "<EnumEntry Name=\"Green\"><Value>1</Value></EnumEntry>"
      "<EnumEntry Name=\"Blue\"><Value>2</Value></EnumEntry><pValue>RatioChannel</pValue></Enumeration>"
      "<Float Name=\"BalanceRatio\"><pValue>Ratio</pValue><Min>0.5</Min><Max>4</Max></Float>"
      "<FloatReg Name=\"Ratio\"><pAddress>RatioAddress</pAddress><Length>4</Length>"
      "<AccessMode>RW</AccessMode><pPort>Device</pPort><Endianess>BigEndian</Endianess></FloatReg>"
      "<IntSwissKnife Name=\"RatioAddress\"><pVariable Name=\"CHANNEL\">RatioChannel</pVariable>"
      "<Formula>0x8020 + CHANNEL * 4</Formula></IntSwissKnife>",
      integer_register("RatioChannel", 0x8010));
}

}  // namespace floatstage::capture
