"""WiFi scans to positions: radio maps and the matchers over them."""
