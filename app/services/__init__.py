"""What the product does: tracking, surveys, venues, access."""
